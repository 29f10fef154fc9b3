// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/slopes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace uwv::testing {
namespace {

const Intrinsics lens{500, 480, 40.3, 29.1};

/// Depth of the plane n . x = distance through every pixel centre; 0 where the plane is behind.
DepthMap plane(Size size, const Eigen::Vector3d& normal, double distance) {
  DepthMap depth(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const double along = normal.dot(unproject(lens, {x + 0.5, y + 0.5}, 1.0));
      const double z = distance / along;
      depth(x, y) = z > 0 ? static_cast<float>(z) : 0.0F;
    }
  return depth;
}

double angle_between(const Eigen::Vector3f& a, const Eigen::Vector3d& b) {
  return std::acos(std::clamp(a.cast<double>().normalized().dot(b.normalized()), -1.0, 1.0));
}

class SlopesTest : public ::testing::Test {
 protected:
  ThreadPool pool_{2};
};

TEST_F(SlopesTest, NormalsOfPlanesAreExactAtAnyTiltAndScale) {
  for (const double tilt_degrees : {0.0, 30.0, 60.0, 80.0, 86.0})
    for (const double turn : {0.0, 1.0, 2.5})
      for (const double distance : {1e-5, 1.0, 1e8}) {
        const double tilt = tilt_degrees * std::numbers::pi / 180;
        const Eigen::Vector3d towards(std::sin(tilt) * std::cos(turn), std::sin(tilt) * std::sin(turn),
                                      -std::cos(tilt));
        const DepthMap depth = plane({80, 60}, towards, -distance);
        for (const int radius : {1, 3}) {
          const SlopeMap slopes = slopes_from_depth(depth, {0.1F, radius}, pool_);
          double worst = 0;
          // Beside the horizon and on the rim a lone neighbour may differ by more than the discontinuity.
          for (int y = radius; y < 60 - radius; ++y)
            for (int x = radius; x < 80 - radius; ++x)
              if (depth(x, y) > 0 && depth(x - radius, y) > 0 && depth(x + radius, y) > 0 && depth(x, y - radius) > 0 &&
                  depth(x, y + radius) > 0)
                worst = std::max(worst, angle_between(normal_from_slope(slopes(x, y), x, y, lens), towards));
          EXPECT_LT(worst, 0.01) << "tilt " << tilt_degrees << ", turn " << turn << ", distance " << distance
                                 << ", radius " << radius;
        }
      }
}

TEST_F(SlopesTest, NoSlopeCrossesADepthEdge) {
  DepthMap depth = plane({40, 30}, {0, 0, 1}, 2.0);
  for (int y = 0; y < 30; ++y)
    for (int x = 20; x < 40; ++x) depth(x, y) = 5.0F;
  const SlopeMap slopes = slopes_from_depth(depth, {}, pool_);
  for (const Slope& slope : slopes.pixels()) {
    EXPECT_NEAR(slope.x, 0, 1e-6);
    EXPECT_NEAR(slope.y, 0, 1e-6);
  }
}

TEST_F(SlopesTest, TiltedSurfaceKeepsItsSlopeUpToItsEdge) {
  const Eigen::Vector3d towards = Eigen::Vector3d(0.6, 0, -0.8);
  DepthMap depth = plane({40, 30}, towards, -2.0);
  for (int y = 0; y < 30; ++y)
    for (int x = 20; x < 40; ++x) depth(x, y) = 50.0F;
  const SlopeMap slopes = slopes_from_depth(depth, {}, pool_);
  for (const int x : {0, 10, 18, 19})
    EXPECT_LT(angle_between(normal_from_slope(slopes(x, 15), x, 15, lens), towards), 0.01) << "column " << x;
}

TEST_F(SlopesTest, LonelyPixelsFaceTheCamera) {
  DepthMap depth(7, 5, 0.0F);
  depth(3, 2) = 4.0F;
  const SlopeMap slopes = slopes_from_depth(depth, {}, pool_);
  EXPECT_EQ(slopes(3, 2), Slope{});
  EXPECT_EQ(slopes_from_depth(DepthMap(1, 1, 3.0F), {}, pool_)(0, 0), Slope{});
}

TEST_F(SlopesTest, AnythingInIsFiniteOut) {
  DepthMap depth(33, 17);
  std::mt19937 random(3);
  const float values[] = {
      0.0F,  1e-6F,  1.0F, 1e9F, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN(),
      -1.0F, 1e-12F, 1e12F};
  for (float& z : depth.pixels()) z = values[random() % std::size(values)];
  const SlopeMap slopes = slopes_from_depth(depth, {}, pool_);
  for (const Slope& slope : slopes.pixels()) {
    EXPECT_TRUE(std::isfinite(slope.x)) << slope.x;
    EXPECT_TRUE(std::isfinite(slope.y)) << slope.y;
  }
}

TEST_F(SlopesTest, NormalsAndSlopesConvertBothWays) {
  std::mt19937 random(5);
  std::normal_distribution<float> gauss;
  NormalMap normals(20, 10, Eigen::Vector3f::Zero());
  for (Eigen::Vector3f& n : normals.pixels())
    n = Eigen::Vector3f(gauss(random), gauss(random), gauss(random)).normalized();
  const SlopeMap slopes = slopes_from_normals(normals, lens);
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 20; ++x) {
      const Eigen::Vector3d ray = unproject(lens, {x + 0.5, y + 0.5}, 1.0);
      const double facing = normals(x, y).cast<double>().dot(ray.normalized());
      if (std::abs(facing) < 0.02) continue;  // edge-on, refused below half a degree
      const Eigen::Vector3d towards = normals(x, y).cast<double>() * (facing > 0 ? -1 : 1);
      EXPECT_LT(angle_between(normal_from_slope(slopes(x, y), x, y, lens), towards), 1e-4) << x << ", " << y;
    }
}

TEST_F(SlopesTest, UnusableNormalsFaceTheCamera) {
  NormalMap normals(3, 1, Eigen::Vector3f::Zero());
  normals(1, 0) = Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
  const Eigen::Vector3d ray = unproject(lens, {2.5, 0.5}, 1.0);
  normals(2, 0) =
      Eigen::Vector3f(static_cast<float>(ray.z()), 0, static_cast<float>(-ray.x())).normalized();  // edge-on
  const SlopeMap slopes = slopes_from_normals(normals, lens);
  for (const Slope& slope : slopes.pixels()) EXPECT_EQ(slope, Slope{});
}

TEST_F(SlopesTest, LimitedSlopesAreSlopesThenLimited) {
  ThreadPool pool(2);
  DepthMap depth = plane({301, 97}, Eigen::Vector3d(0.5, 0.3, 0.81), 3.0);
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 100; x < 200; ++x) depth(x, y) = 1.0F + 0.5F * static_cast<float>(x - 100);  // a smeared edge
  for (const double max_tilt : {0.5, 1.5, std::numbers::pi / 2}) {
    SlopeOptions options;
    options.max_tilt = max_tilt;
    SlopeMap wanted = slopes_from_depth(depth, options, pool), got;
    limit_tilt(wanted, lens, max_tilt, pool);
    limited_slopes_from_depth(depth, lens, options, pool, got);
    EXPECT_EQ(wanted, got);
  }
}

TEST_F(SlopesTest, DoesNotDependOnTheNumberOfThreads) {
  const DepthMap depth = plane({301, 97}, Eigen::Vector3d(0.5, 0.3, 0.81), 3.0);
  ThreadPool one(1), five(5);
  EXPECT_EQ(slopes_from_depth(depth, {}, one), slopes_from_depth(depth, {}, five));
}

TEST_F(SlopesTest, RefusesOptionsOutOfRange) {
  EXPECT_THROW((SlopeOptions{0.0F, 1}.check()), std::invalid_argument);
  EXPECT_THROW((SlopeOptions{1.5F, 1}.check()), std::invalid_argument);
  EXPECT_THROW((SlopeOptions{0.1F, 0}.check()), std::invalid_argument);
}

}  // namespace
}  // namespace uwv::testing
