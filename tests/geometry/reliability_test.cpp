// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/reliability.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace uwv::testing {
namespace {

/// The definition, pixel by pixel.
bool reliable_at(const DepthMap& depth, int cx, int cy, const ReliabilityOptions& options) {
  const int r = options.window / 2;
  double high = -1e30, low = 1e30, sum = 0;
  int count = 0;
  for (int y = cy - r; y <= cy + r; ++y)
    for (int x = cx - r; x <= cx + r; ++x) {
      if (!depth.contains(x, y)) continue;
      high = std::max<double>(high, depth(x, y));
      low = std::min<double>(low, depth(x, y));
      sum += depth(x, y);
      ++count;
    }
  const double mean = sum / (options.count_padding ? options.window * options.window : count);
  return (high - low) / (mean + 1e-6) < options.ratio && depth(cx, cy) > 0;
}

TEST(ReliabilityTest, FollowsTheDefinition) {
  ThreadPool pool(3);
  std::mt19937 random(11);
  std::uniform_real_distribution<float> noise(0.97F, 1.03F);
  DepthMap depth(61, 75);
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 0; x < depth.width(); ++x)
      depth(x, y) = (x < 30 ? 2.0F : 2.2F) * noise(random) * (random() % 50 != 0 ? 1.0F : 0.0F);
  for (const int window : {1, 3, 5, 9, 131})
    for (const bool padding : {true, false}) {
      const ReliabilityOptions options{true, window, 0.11F, padding};
      const ValidityMask mask = reliable_depth(depth, options, pool);
      for (int y = 0; y < depth.height(); ++y)
        for (int x = 0; x < depth.width(); ++x)
          ASSERT_EQ(mask(x, y) != 0, reliable_at(depth, x, y, options)) << x << ", " << y << ", window " << window;
    }
}

TEST(ReliabilityTest, CountedPaddingMakesBordersStricter) {
  ThreadPool pool(1);
  DepthMap depth(20, 20, 1.0F);
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 20; ++x) depth(x, y) = 1.0F + 0.018F * static_cast<float>(x);
  const auto count = [&](bool padding) { return reliable_depth(depth, {true, 5, 0.1F, padding}, pool).count(); };
  EXPECT_LT(count(true), count(false));
}

TEST(ReliabilityTest, OffKeepsEveryValidDepth) {
  ThreadPool pool(1);
  DepthMap depth(3, 2, 0.0F);
  depth(1, 1) = 1e-6F;
  depth(2, 1) = 1e9F;
  EXPECT_EQ(reliable_depth(depth, {false}, pool).count(), 2U);
}

TEST(ReliabilityTest, HandlesEmptyAndOnePixelPictures) {
  ThreadPool pool(2);
  EXPECT_TRUE(reliable_depth(DepthMap(), {}, pool).empty());
  EXPECT_EQ(reliable_depth(DepthMap(1, 1, 2.0F), {true, 5, 0.1F, false}, pool).count(), 1U);
  EXPECT_EQ(reliable_depth(DepthMap(1, 1, 0.0F), {}, pool).count(), 0U);
}

TEST(ReliabilityTest, RefusesOptionsOutOfRange) {
  EXPECT_THROW((ReliabilityOptions{true, 4}.check()), std::invalid_argument);
  EXPECT_THROW((ReliabilityOptions{true, 5, 0.0F}.check()), std::invalid_argument);
}

}  // namespace
}  // namespace uwv::testing
