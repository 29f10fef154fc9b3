// SPDX-License-Identifier: Apache-2.0
// Depth maps for the tests of depth files, and a comparison that prints the worst pixel.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "uwv/core/depth.h"

namespace uwv::test {

/// Every pixel different: 1, 1.25, 1.5, ... in row-major order, plus `offset`.
inline DepthMap ramp_depth(Size size, float offset = 0) {
  DepthMap depth(size);
  float z = 1 + offset;
  for (float& value : depth.pixels()) {
    value = z;
    z += 0.25F;
  }
  return depth;
}

/// Values that estimators really write, valid and not.
inline DepthMap nasty_depth() {
  const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  DepthMap depth(5, 2);
  const float values[] = {1e-6F, 1e9F, nan, inf, -inf, -3, 0, 1e-30F, 1e30F, 2.5F};
  std::copy(std::begin(values), std::end(values), depth.data());
  return depth;
}

/// nasty_depth() as it must come back: what is no depth is 0.
inline DepthMap nasty_depth_as_read() {
  DepthMap depth(5, 2);
  const float values[] = {1e-6F, 1e9F, 0, 0, 0, 0, 0, 0, 0, 2.5F};
  std::copy(std::begin(values), std::end(values), depth.data());
  return depth;
}

inline void expect_depth_near(const DepthMap& got, const DepthMap& wanted, double tolerance) {
  ASSERT_EQ(got.width(), wanted.width());
  ASSERT_EQ(got.height(), wanted.height());
  double worst = 0;
  int worst_x = 0, worst_y = 0;
  for (int y = 0; y < got.height(); ++y)
    for (int x = 0; x < got.width(); ++x) {
      const double difference = std::abs(double{got(x, y)} - double{wanted(x, y)});
      if (difference <= worst) continue;  // a NaN counts as worst
      worst = difference;
      worst_x = x;
      worst_y = y;
    }
  EXPECT_LE(worst, tolerance) << "worst at (" << worst_x << ", " << worst_y << "): " << got(worst_x, worst_y)
                              << " instead of " << wanted(worst_x, worst_y);
}

}  // namespace uwv::test
