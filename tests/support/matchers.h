// SPDX-License-Identifier: Apache-2.0
// Comparisons of our types for GoogleTest. Each checks the shape first and, when it fails, says how many places differ
// and shows the worst one.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

#include "uwv/core/camera.h"
#include "uwv/core/depth.h"
#include "uwv/core/mask.h"

#define EXPECT_DEPTH_NEAR(actual, expected, relative) \
  EXPECT_TRUE(::uwv::testing::depth_near(actual, expected, relative))
#define EXPECT_IMAGE_NEAR(actual, expected, tolerance) \
  EXPECT_TRUE(::uwv::testing::image_near(actual, expected, tolerance))
#define EXPECT_MASK_AGREES(actual, expected, min_share) \
  EXPECT_TRUE(::uwv::testing::mask_agrees(actual, expected, min_share))
#define EXPECT_RIGID_NEAR(actual, expected, tolerance) \
  EXPECT_TRUE(::uwv::testing::rigid_near(actual, expected, tolerance))

namespace uwv::testing {

/// The folder of golden data for `area`: $UWV_FIXTURES/<area> when that is set, else the copy in tests/data.
inline std::string fixture_folder(const std::string& area) {
  const char* other = std::getenv("UWV_FIXTURES");
  return std::string(other != nullptr && *other != '\0' ? other : UWV_TEST_DATA) + "/" + area;
}

template <class Picture>
::testing::AssertionResult same_size(const Picture& actual, const Picture& expected) {
  if (actual.size() == expected.size()) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "the picture is " << actual.width() << "x" << actual.height() << ", expected "
                                       << expected.width() << "x" << expected.height();
}

/// Remembers the largest of many differences and how many were too large.
class Worst {
 public:
  explicit Worst(double tolerance) : tolerance_(tolerance) {}
  /// NaN counts as infinitely different.
  void see(int x, int y, double difference) {
    if (std::isnan(difference)) difference = HUGE_VAL;
    if (!(difference <= tolerance_)) ++failed_;
    if (difference <= difference_) return;
    difference_ = difference;
    x_ = x;
    y_ = y;
  }
  std::size_t failed() const { return failed_; }
  int x() const { return x_; }
  int y() const { return y_; }
  double difference() const { return difference_; }

 private:
  double tolerance_;
  double difference_ = -1;
  std::size_t failed_ = 0;
  int x_ = 0, y_ = 0;
};

/// Relative difference |a - b| <= relative * b at every pixel; invalid (0) must meet invalid.
inline ::testing::AssertionResult depth_near(const DepthMap& actual, const DepthMap& expected, double relative) {
  if (auto same = same_size(actual, expected); !same) return same;
  Worst worst(relative);
  for (int y = 0; y < expected.height(); ++y) {
    for (int x = 0; x < expected.width(); ++x) {
      const double a = static_cast<double>(actual(x, y));
      const double b = static_cast<double>(expected(x, y));
      worst.see(x, y, a == b ? 0 : b == 0 ? HUGE_VAL : std::abs(a - b) / std::abs(b));
    }
  }
  if (worst.failed() == 0) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << worst.failed() << " of " << expected.size().pixels()
                                       << " depths differ by more than " << relative << "; worst at (" << worst.x()
                                       << ", " << worst.y() << "): " << actual(worst.x(), worst.y()) << ", expected "
                                       << expected(worst.x(), worst.y());
}

/// No channel of any pixel differs by more than `tolerance` of 255 steps.
inline ::testing::AssertionResult image_near(const ImageRgb& actual, const ImageRgb& expected, int tolerance) {
  if (auto same = same_size(actual, expected); !same) return same;
  Worst worst(tolerance);
  for (int y = 0; y < expected.height(); ++y) {
    for (int x = 0; x < expected.width(); ++x) {
      const Rgb8 a = actual(x, y);
      const Rgb8 b = expected(x, y);
      worst.see(x, y, std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)}));
    }
  }
  if (worst.failed() == 0) return ::testing::AssertionSuccess();
  const Rgb8 a = actual(worst.x(), worst.y());
  const Rgb8 b = expected(worst.x(), worst.y());
  return ::testing::AssertionFailure() << worst.failed() << " of " << expected.size().pixels()
                                       << " pixels differ by more than " << tolerance << "; worst at (" << worst.x()
                                       << ", " << worst.y() << "): (" << int{a.r} << ", " << int{a.g} << ", "
                                       << int{a.b} << "), expected (" << int{b.r} << ", " << int{b.g} << ", "
                                       << int{b.b} << ")";
}

/// At least `min_share` of the pixels are equal; 1 asks for all.
template <class Tag>
::testing::AssertionResult mask_agrees(const Mask<Tag>& actual, const Mask<Tag>& expected, double min_share) {
  if (auto same = same_size(actual, expected); !same) return same;
  Worst worst(0);
  for (int y = 0; y < expected.height(); ++y)
    for (int x = 0; x < expected.width(); ++x) worst.see(x, y, (actual(x, y) != 0) == (expected(x, y) != 0) ? 0 : 1);
  const double pixels = static_cast<double>(expected.size().pixels());
  const double share = pixels == 0 ? 1.0 : 1.0 - static_cast<double>(worst.failed()) / pixels;
  if (share >= min_share) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "masks agree on " << share << " of the pixels, wanted " << min_share << "; "
                                       << worst.failed() << " differ, the first at (" << worst.x() << ", " << worst.y()
                                       << "): " << int{actual(worst.x(), worst.y())} << ", expected "
                                       << int{expected(worst.x(), worst.y())};
}

/// Rotation entries differ by at most `tolerance`, translations by at most `tolerance` * (1 + |expected translation|).
inline ::testing::AssertionResult rigid_near(const Rigid3& actual, const Rigid3& expected, double tolerance) {
  const double rotation = (actual.rotation - expected.rotation).cwiseAbs().maxCoeff();
  const double translation = (actual.translation - expected.translation).norm() / (1 + expected.translation.norm());
  if (rotation <= tolerance && translation <= tolerance) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "poses differ by " << rotation << " in rotation and " << translation
                                       << " in translation, allowed " << tolerance << "; actual\n"
                                       << actual.matrix() << "\nexpected\n"
                                       << expected.matrix();
}

}  // namespace uwv::testing
