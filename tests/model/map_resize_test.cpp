// SPDX-License-Identifier: Apache-2.0
#include "model/map_resize.h"

#include <gtest/gtest.h>

namespace uwv::model {
namespace {

TEST(MapResize, keeps_a_ramp_between_the_border_pixels) {
  KnownMap map{FloatMap(Size{10, 6}), FloatMap(Size{10, 6}, 0.7F)};
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 10; ++x) map.value(x, y) = static_cast<float>(2 * (x + 0.5) / 10 + 3 * (y + 0.5) / 6);
  const KnownMap big = resized(map, {70, 42});
  for (int y = 4; y < 38; ++y) {
    for (int x = 4; x < 66; ++x) {
      EXPECT_NEAR(big.value(x, y), 2 * (x + 0.5) / 70 + 3 * (y + 0.5) / 42, 1e-5);
      EXPECT_NEAR(big.confidence(x, y), 0.7F, 1e-6);
    }
  }
}

TEST(MapResize, mixes_nothing_unknown_in) {
  KnownMap map{FloatMap(Size{4, 1}, 5.0F), FloatMap(Size{4, 1}, 1.0F)};
  map.value(1, 0) = 1e30F;
  map.confidence(1, 0) = 0;
  const KnownMap big = resized(map, {16, 4});
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 16; ++x) {
      const bool unknown = x >= 4 && x < 8;
      EXPECT_EQ(big.confidence(x, y) == 0, unknown) << x;
      EXPECT_EQ(big.value(x, y), unknown ? 0.0F : 5.0F) << x;
    }
  }
}

TEST(MapResize, works_from_and_to_one_pixel) {
  const KnownMap one{FloatMap(Size{1, 1}, 3.0F), FloatMap(Size{1, 1}, 1.0F)};
  EXPECT_EQ(resized(one, {7, 5}).value(6, 4), 3.0F);
  const KnownMap many{FloatMap(Size{7, 5}, 3.0F), FloatMap(Size{7, 5}, 1.0F)};
  EXPECT_EQ(resized(many, {1, 1}).value(0, 0), 3.0F);
}

TEST(MapResize, keeps_directions_of_unit_length) {
  VectorMap map(Size{2, 1});
  map(0, 0) = {1, 0, 0};
  map(1, 0) = {0, 0, -1};
  const VectorMap big = resized_directions(map, {8, 1});
  for (const auto& direction : big.pixels()) EXPECT_NEAR(direction.norm(), 1, 1e-6);
  map(0, 0).setZero();
  EXPECT_TRUE(resized_directions(map, {8, 1})(0, 0).isZero());
  EXPECT_EQ(resized_directions(map, {8, 1})(4, 0), Eigen::Vector3f(0, 0, -1));
}

}  // namespace
}  // namespace uwv::model
