// SPDX-License-Identifier: Apache-2.0
#include "model/pose_encoding.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

namespace uwv::model {
namespace {

std::array<double, 9> encoded(const Rigid3& transform, const Intrinsics& k, Size frame, double quaternion_length) {
  const Eigen::Quaterniond q(transform.rotation);
  const Eigen::Vector4d xyzw = q.coeffs() * quaternion_length;
  const Eigen::Vector3d& t = transform.translation;
  return {t.x(),
          t.y(),
          t.z(),
          xyzw[0],
          xyzw[1],
          xyzw[2],
          xyzw[3],
          2 * std::atan(frame.height / (2 * k.fy)),
          2 * std::atan(frame.width / (2 * k.fx))};
}

TEST(PoseEncoding, is_undone) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const Size frame{832, 480};
  for (const double length : {1.0, -1.0, 0.3, 50.0}) {
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector3d axis = Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
      const Rigid3 transform{Eigen::AngleAxisd(3 * normal(random), axis).toRotationMatrix(),
                             {normal(random), normal(random), 1e4 * normal(random)}};
      const Intrinsics k{300 + 100 * std::abs(normal(random)), 500, 416, 240};
      const EncodedCamera back = decode_pose(encoded(transform, k, frame, length), frame, "test");
      EXPECT_LT((back.transform.rotation - transform.rotation).norm(), 1e-12);
      EXPECT_EQ(back.transform.translation, transform.translation);
      EXPECT_NEAR(back.intrinsics.fx, k.fx, 1e-9);
      EXPECT_NEAR(back.intrinsics.fy, k.fy, 1e-9);
      EXPECT_EQ(back.intrinsics.cx, 416);
    }
  }
}

TEST(PoseEncoding, a_quarter_turn_about_y_is_as_written) {
  const double h = std::sqrt(0.5);
  const std::array<double, 9> numbers{1, 2, 3, 0, h, 0, h, 1, 1};
  const EncodedCamera camera = decode_pose(numbers, {100, 100}, "test");
  // x forward after the turn: z of the source becomes x of the target.
  EXPECT_LT((camera.transform * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(2, 2, 3)).norm(), 1e-12);
}

TEST(PoseEncoding, refuses_what_is_no_camera) {
  const std::array<double, 9> no_rotation{0, 0, 0, 0, 0, 0, 0, 1, 1};
  EXPECT_THROW(decode_pose(no_rotation, {10, 10}, "test"), Error);
  for (const double fov : {0.0, -1.0, 3.2, std::nan("")}) {
    const std::array<double, 9> no_view{0, 0, 0, 0, 0, 0, 1, 1, fov};
    EXPECT_THROW(decode_pose(no_view, {10, 10}, "test"), Error) << fov;
  }
}

}  // namespace
}  // namespace uwv::model
