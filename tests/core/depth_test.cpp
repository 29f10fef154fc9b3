// SPDX-License-Identifier: Apache-2.0
#include "uwv/core/depth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace uwv {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float inf = std::numeric_limits<float>::infinity();

DepthMap row_of(std::initializer_list<float> values) {
  DepthMap depth(static_cast<int>(values.size()), 1);
  std::copy(values.begin(), values.end(), depth.data());
  return depth;
}

TEST(Depth, ValidityAtTheBounds) {
  for (const float good : {min_depth, 1e-6F, 1.0F, 1e9F, max_depth}) EXPECT_TRUE(is_valid_depth(good)) << good;
  for (const float bad : {0.0F, -0.0F, -1.0F, nan, inf, -inf, std::nextafter(min_depth, 0.0F),
                          std::nextafter(max_depth, inf), std::numeric_limits<float>::denorm_min()})
    EXPECT_FALSE(is_valid_depth(bad)) << bad;
}

TEST(Depth, SanitizeZeroesWhatIsInvalidAndCountsIt) {
  DepthMap depth = row_of({1.0F, nan, inf, -inf, -2.0F, 0.0F, -0.0F, 1e-40F, 1e13F, 3.5F});
  EXPECT_EQ(sanitize_depth(depth), 6U) << "NaN, both infinities, -2, the denormal and 1e13";
  EXPECT_EQ(depth, row_of({1.0F, 0, 0, 0, 0, 0, 0, 0, 0, 3.5F}));
  for (const float z : depth.pixels()) EXPECT_FALSE(std::signbit(z)) << "an invalid depth is +0";
  EXPECT_EQ(sanitize_depth(depth), 0U) << "a second time there is nothing left to change";
}

TEST(Depth, MedianIsTheLowerMiddleOfTheValidOnes) {
  EXPECT_EQ(median_depth(row_of({3, 1, 2})), 2.0F);
  EXPECT_EQ(median_depth(row_of({4, 1, 3, 2})), 2.0F) << "even count: the lower of the two middles";
  EXPECT_EQ(median_depth(row_of({4, 0, nan, 1, inf, -7, 3, 2})), 2.0F) << "invalid values do not count";
  EXPECT_EQ(median_depth(row_of({5})), 5.0F);
}

TEST(Depth, MedianOfNothingIsZero) {
  EXPECT_EQ(median_depth(DepthMap{}), 0.0F);
  EXPECT_EQ(median_depth(row_of({0, nan, -1})), 0.0F);
}

TEST(Depth, MedianAgreesWithSorting) {
  std::mt19937 rng(8);
  std::uniform_real_distribution<float> uniform(-0.2F, 1.0F);
  for (int width = 1; width < 60; ++width) {
    DepthMap depth(width, 3);
    for (float& z : depth.pixels()) z = uniform(rng);
    const DepthMap before = depth;
    std::vector<float> valid;
    for (const float z : depth.pixels())
      if (z > 0) valid.push_back(z);
    std::sort(valid.begin(), valid.end());
    ASSERT_EQ(median_depth(depth), valid.empty() ? 0.0F : valid[(valid.size() - 1) / 2]) << "width " << width;
    ASSERT_EQ(depth, before) << "the map itself stays as it is";
  }
}

}  // namespace
}  // namespace uwv
