// SPDX-License-Identifier: Apache-2.0
#include "uwv/core/camera.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <random>

namespace uwv {
namespace {

constexpr double degree = std::numbers::pi / 180;

Eigen::Matrix3d rotation(double yaw, double pitch, double roll) {
  return (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitX()) *
          Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()))
      .toRotationMatrix();
}

Camera camera_at(const Eigen::Vector3d& centre_in_world, const Eigen::Matrix3d& world_from_cam) {
  return {{500, 510, 320, 240}, {world_from_cam, centre_in_world}, {640, 480}};
}

double distance(const Rigid3& a, const Rigid3& b) { return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff(); }

TEST(Intrinsics, InverseMatrixUndoesMatrix) {
  for (const Intrinsics& k : {Intrinsics{500, 510, 320, 240}, Intrinsics{-500, 3, -7, 1e5}}) {
    EXPECT_LT((k.matrix() * k.inverse_matrix() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-10);
  }
}

TEST(Intrinsics, ResizedKeepsPixelEdges) {
  const Size from{741, 500}, to{832, 480};
  const Intrinsics before{994.978, 990, 311.193, 254.877};
  const Intrinsics after = before.resized(from, to);
  for (const Eigen::Vector2d& edge : {Eigen::Vector2d(0, 0), Eigen::Vector2d(741, 500), Eigen::Vector2d(100, 499)}) {
    const Eigen::Vector3d x_in_cam = unproject(before, edge, 2.5);
    Eigen::Vector2d pixel;
    ASSERT_TRUE(project(after, x_in_cam, pixel));
    EXPECT_NEAR(pixel.x(), edge.x() * to.width / from.width, 1e-9);
    EXPECT_NEAR(pixel.y(), edge.y() * to.height / from.height, 1e-9);
  }
  const Intrinsics back = after.resized(to, from);
  EXPECT_NEAR(back.fx, before.fx, 1e-9);
  EXPECT_NEAR(back.cy, before.cy, 1e-9);
  EXPECT_EQ(before.resized(from, from), before);
}

TEST(Intrinsics, ResizedRefusesEmptyPictures) {
  const Intrinsics k{1, 1, 0, 0};
  EXPECT_THROW(k.resized({0, 5}, {5, 5}), std::invalid_argument);
  EXPECT_THROW(k.resized({5, 5}, {5, -1}), std::invalid_argument);
}

TEST(Intrinsics, FieldOfViewSpansThePicture) {
  const Size size{640, 480};
  for (const double fov : {1 * degree, 60 * degree, 90 * degree, 170 * degree}) {
    const Intrinsics k = Intrinsics::from_fov_x(fov, size);
    const Eigen::Vector3d left = unproject(k, {0, size.height / 2.0}, 1);
    const Eigen::Vector3d right = unproject(k, {size.width, size.height / 2.0}, 1);
    EXPECT_NEAR(std::acos(left.normalized().dot(right.normalized())), fov, 1e-9);
    EXPECT_EQ(k.fx, k.fy);
    EXPECT_EQ(k.cx, 320);
    EXPECT_EQ(k.cy, 240);
  }
}

TEST(Intrinsics, FieldOfViewOutOfRangeIsRefused) {
  for (const double bad : {0.0, -1.0, std::numbers::pi, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THROW(Intrinsics::from_fov_x(bad, {640, 480}), std::invalid_argument) << bad;
}

TEST(Intrinsics, IntegerCentresShiftTheOriginHalfAPixel) {
  // The reference calls the centre of the first pixel (0, 0); we call it (0.5, 0.5).
  const double cx = 320, cy = 240, f = 500;
  const Intrinsics ours = Intrinsics::from_integer_centres(f, f, cx, cy);
  const Eigen::Vector3d theirs_of_pixel_7_9((7 - cx) / f * 3, (9 - cy) / f * 3, 3);
  EXPECT_LT((unproject(ours, {7.5, 9.5}, 3) - theirs_of_pixel_7_9).norm(), 1e-15);
}

TEST(Projection, RoundTripAcrossExtremes) {
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const double fov : {1 * degree, 60 * degree, 170 * degree}) {
    Intrinsics k = Intrinsics::from_fov_x(fov, {640, 480});
    for (const double mirror : {1.0, -1.0}) {
      k.fy = mirror * std::abs(k.fy);
      for (const double z : {1e-6, 1.0, 1e9}) {
        for (int i = 0; i < 200; ++i) {
          const Eigen::Vector2d before(unit(rng) * 640, unit(rng) * 480);
          const Eigen::Vector3d x_in_cam = unproject(k, before, z);
          ASSERT_EQ(x_in_cam.z(), z);
          Eigen::Vector2d after;
          ASSERT_TRUE(project(k, x_in_cam, after));
          ASSERT_LT((after - before).norm(), 1e-9) << "fov " << fov << " z " << z << " at " << before.transpose();
        }
      }
    }
  }
}

TEST(Projection, AxesAreRightDownForward) {
  const Intrinsics k{100, 100, 50, 40};
  Eigen::Vector2d pixel;
  ASSERT_TRUE(project(k, {0.1, 0, 1}, pixel));
  EXPECT_EQ(pixel, Eigen::Vector2d(60, 40)) << "+x is to the right";
  ASSERT_TRUE(project(k, {0, 0.1, 1}, pixel));
  EXPECT_EQ(pixel, Eigen::Vector2d(50, 50)) << "+y is downwards";
}

TEST(Projection, NothingBehindOrOnTheCameraPlane) {
  const Intrinsics k{100, 100, 50, 40};
  Eigen::Vector2d pixel(-1, -2);
  for (const double z : {0.0, -0.0, -1e-300, -1.0, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_FALSE(project(k, {0.1, 0.1, z}, pixel)) << z;
  EXPECT_EQ(pixel, Eigen::Vector2d(-1, -2)) << "a refused projection leaves the pixel alone";
}

TEST(TargetFromSource, AgreesWithThePosesProduct) {
  const Camera target = camera_at({1, -2, 3}, rotation(0.3, -0.2, 0.1));
  const Camera source = camera_at({-4, 0.5, 2}, rotation(-1.2, 0.4, 2));
  EXPECT_LT(distance(target_from_source(target, source), target.cam_from_world() * source.world_from_cam), 1e-14 * 20);
}

TEST(TargetFromSource, Chains) {
  const Camera a = camera_at({1, -2, 3}, rotation(0.3, -0.2, 0.1));
  const Camera b = camera_at({0, 4, 1}, rotation(2.3, 0.2, -1));
  const Camera c = camera_at({-4, 0.5, 2}, rotation(-1.2, 0.4, 2));
  EXPECT_LT(distance(target_from_source(a, b) * target_from_source(b, c), target_from_source(a, c)), 1e-13);
  EXPECT_LT(distance(target_from_source(a, b).inverse(), target_from_source(b, a)), 1e-13);
}

TEST(TargetFromSource, SameCameraIsExactlyTheIdentity) {
  const Camera camera = camera_at({1e7, -3e6, 12.34}, rotation(0.3, -0.2, 0.1));
  EXPECT_EQ(target_from_source(camera, camera), Rigid3{});
}

TEST(TargetFromSource, PureTranslationDoesNotRotate) {
  const Camera source = camera_at({1, 2, 3}, rotation(0.3, -0.2, 0.1));
  const Camera target = camera_at({1.5, 2, 3}, rotation(0.3, -0.2, 0.1));
  EXPECT_EQ(target_from_source(target, source).rotation, Eigen::Matrix3d::Identity());
}

TEST(TargetFromSource, FarFromTheOriginNothingIsLost) {
  // Centres on a grid of 2^-10, so that moving them by 1e7 is exact and only our own arithmetic can lose digits.
  const Eigen::Vector3d near_source(0.25, -1.5, 0.0078125), near_target(0.5, -1.25, 0.0146484375);
  const Eigen::Vector3d far_away(1e7, -2e7, 3e7);
  const Eigen::Matrix3d source_rotation = rotation(0.3, -0.2, 0.1), target_rotation = rotation(0.5, 0.1, 0.2);
  const Rigid3 near =
      target_from_source(camera_at(near_target, target_rotation), camera_at(near_source, source_rotation));
  const Rigid3 far = target_from_source(camera_at(near_target + far_away, target_rotation),
                                        camera_at(near_source + far_away, source_rotation));
  EXPECT_EQ(far, near);
}

}  // namespace
}  // namespace uwv
