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

/// A square at depth 2 before a wall at 4, blurred `times` times by a 3x3 box as a network's answer would be.
DepthMap square(int times) {
  DepthMap depth(80, 60, 4.0F);
  for (int y = 15; y < 45; ++y)
    for (int x = 20; x < 60; ++x) depth(x, y) = 2.0F;
  for (; times > 0; --times) {
    const DepthMap sharp = depth;
    for (int y = 1; y < 59; ++y)
      for (int x = 1; x < 79; ++x) {
        float sum = 0;
        for (int tap = 0; tap < 9; ++tap) sum += sharp(x - 1 + tap % 3, y - 1 + tap / 3);
        depth(x, y) = sum / 9;
      }
  }
  return depth;
}

TEST(EdgeSharpnessTest, TellsSharpEdgesFromSmearedOnes) {
  ThreadPool pool(3);
  const EdgeSharpness sharp = edge_sharpness(square(0), pool);
  EXPECT_EQ(sharp.edges, 2U * (30 + 40));
  EXPECT_EQ(sharp.smeared, 0U);
  EXPECT_FALSE(sharp.smears());
  for (const int times : {1, 2, 3}) {
    const EdgeSharpness smeared = edge_sharpness(square(times), pool);
    EXPECT_GT(smeared.edges, 70U) << times;  // near the corners neither end stays constant
    EXPECT_GT(smeared.smeared_share(), 0.9) << times;
    EXPECT_TRUE(smeared.smears()) << times;
  }
}

TEST(EdgeSharpnessTest, DoesNotDependOnTheUnitOrTheThreads) {
  ThreadPool one(1), four(4);
  DepthMap depth = square(1);
  const EdgeSharpness metres = edge_sharpness(depth, one);
  for (const float unit : {1e-6F, 1e9F}) {
    DepthMap scaled = depth;
    for (float& z : scaled.pixels()) z *= unit;
    const EdgeSharpness other = edge_sharpness(scaled, four);
    EXPECT_EQ(other.edges, metres.edges) << unit;
    EXPECT_EQ(other.smeared, metres.smeared) << unit;
  }
}

TEST(EdgeSharpnessTest, AGrazingFloorIsNoEdge) {
  ThreadPool pool(2);
  DepthMap floor(64, 64);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) floor(x, y) = 60.0F / (0.5F + static_cast<float>(y));
  EXPECT_EQ(edge_sharpness(floor, pool).edges, 0U);
}

TEST(EdgeSharpnessTest, NothingToSeeIsSharp) {
  ThreadPool pool(2);
  DepthMap holes = square(0);
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 80; x += 3) holes(x, y) = 0;
  for (const DepthMap& depth : {DepthMap(), DepthMap(1, 1, 1.0F), DepthMap(3, 2, 1.0F), DepthMap(50, 50)}) {
    const EdgeSharpness sharpness = edge_sharpness(depth, pool);
    EXPECT_EQ(sharpness.edges, 0U);
    EXPECT_FALSE(sharpness.smears());
  }
  // No seven values in a row: only edges down the columns that are whole count.
  EXPECT_LE(edge_sharpness(holes, pool).edges, 2U * 40);
}

TEST(ReliabilityTest, RefusesOptionsOutOfRange) {
  EXPECT_THROW((ReliabilityOptions{true, 4}.check()), std::invalid_argument);
  EXPECT_THROW((ReliabilityOptions{true, 5, 0.0F}.check()), std::invalid_argument);
}

}  // namespace
}  // namespace uwv::testing
