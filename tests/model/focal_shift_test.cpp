// SPDX-License-Identifier: Apache-2.0
#include "model/focal_shift.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace uwv::model {
namespace {

/// Points of a wavy wall seen with this focal length; what is returned lacks `shift` in z and is `unit` times larger.
VectorMap wavy_points(Size map, Size frame, double focal, double shift, double unit) {
  VectorMap points(map);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const double u = ((x + 0.5) / map.width - 0.5) * frame.width, v = ((y + 0.5) / map.height - 0.5) * frame.height;
      const double z = 4 + std::sin(x * 0.21) + 1.5 * std::cos(y * 0.17);
      points(x, y) = (unit * Eigen::Vector3d(u / focal * z, v / focal * z, z - shift)).cast<float>();
    }
  }
  return points;
}

struct Case {
  Size map, frame;
  double focal, shift, unit;
};

class FocalShiftOf : public testing::TestWithParam<Case> {};

TEST_P(FocalShiftOf, known_points_is_recovered) {
  const Case& c = GetParam();
  const VectorMap points = wavy_points(c.map, c.frame, c.focal, c.shift, c.unit);
  const FocalShift found = recover_focal_shift(points, FloatMap(c.map, 1.0F), c.frame);
  EXPECT_TRUE(found.shift_known);
  EXPECT_NEAR(found.focal / c.focal, 1, 1e-4);
  EXPECT_NEAR(found.shift / c.unit, c.shift, 1e-3);
  EXPECT_LT(found.residual, 1e-3 * c.frame.width);
}

INSTANTIATE_TEST_SUITE_P(
    model, FocalShiftOf,
    testing::Values(Case{{70, 56}, {640, 512}, 500, 0, 1}, Case{{70, 56}, {640, 512}, 500, -0.8, 1},
                    // Points behind the camera before the shift, a long lens, a wide one, tall pictures, odd units.
                    Case{{70, 56}, {640, 512}, 500, 3.5, 1}, Case{{70, 56}, {640, 512}, 2500, 0.5, 1},
                    Case{{70, 56}, {640, 512}, 150, 0.5, 1}, Case{{28, 98}, {200, 700}, 400, 1, 1},
                    Case{{70, 56}, {640, 512}, 500, 0.7, 1e-6}, Case{{70, 56}, {640, 512}, 500, 0.7, 1e6}));

TEST(FocalShift, unknown_points_have_no_say) {
  const Size map{60, 40}, frame{600, 400};
  VectorMap points = wavy_points(map, frame, 450, 0.4, 1);
  FloatMap known(map, 1.0F);
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 60; ++x) {
      points(x, y).setConstant(std::numeric_limits<float>::quiet_NaN());
      known(x, y) = 0;
    }
  EXPECT_NEAR(recover_focal_shift(points, known, frame).focal, 450, 0.1);
}

TEST(FocalShift, of_a_wall_facing_the_camera_is_left_at_zero) {
  const Size map{32, 32}, frame{320, 320};
  VectorMap points(map);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x)
      points(x, y) = {static_cast<float>((x + 0.5 - 16) * 10 / 300 * 2),
                      static_cast<float>((y + 0.5 - 16) * 10 / 300 * 2), 2};
  const FocalShift found = recover_focal_shift(points, FloatMap(map, 1.0F), frame);
  EXPECT_FALSE(found.shift_known);
  EXPECT_EQ(found.shift, 0);
  EXPECT_NEAR(found.focal, 300, 0.01);
}

TEST(FocalShift, needs_points) {
  EXPECT_EQ(recover_focal_shift(VectorMap(Size{4, 4}), FloatMap(Size{4, 4}), {4, 4}).focal, 0);
  EXPECT_EQ(recover_focal_shift(VectorMap(Size{1, 1}), FloatMap(Size{1, 1}, 1.0F), {4, 4}).focal, 0);
  EXPECT_EQ(recover_focal_shift(VectorMap(Size{9, 9}), FloatMap(Size{9, 9}, 1.0F), {4, 4}).focal, 0);
}

}  // namespace
}  // namespace uwv::model
