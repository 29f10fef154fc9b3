// SPDX-License-Identifier: Apache-2.0
#include "pipeline/scene_choices.h"

#include <gtest/gtest.h>

namespace uwv::pipeline {
namespace {

/// Points at depths 2 to 4 before cameras that step sideways and turn.
SfmResult walk(int frames, double step, double turn) {
  SfmResult sfm;
  sfm.motion = ClipMotion::moving;
  for (int i = 0; i < frames; ++i) {
    Camera camera{Intrinsics::from_fov_x(1, {320, 240}), {}, {320, 240}};
    camera.world_from_cam.translation.x() = i * step;
    camera.world_from_cam.rotation = Eigen::AngleAxisd(i * turn, Eigen::Vector3d::UnitY()).toRotationMatrix();
    sfm.cameras.push_back(camera);
  }
  for (int k = 0; k < 99; ++k) {
    ScenePoint point;
    point.x_in_world = {0.01 * (k % 9), 0.01 * (k / 9), 2 + 2.0 * k / 98};
    for (int i = 0; i < frames; ++i) point.observations.push_back({i, Eigen::Vector2d::Zero()});
    sfm.points.push_back(point);
  }
  return sfm;
}

TEST(SceneChoices, ParallaxOfAFrameIsWhatTurningDoesNotExplain) {
  const double fx = Intrinsics::from_fov_x(1, {320, 240}).fx;
  const double sideways = parallax_per_frame(walk(5, 0.03, 0));
  // Half of the points shift by more than this against those of the middle depth, 3: those at 2.5 by fx * step / 15.
  EXPECT_NEAR(sideways, fx * 0.03 * (1 / 2.5 - 1 / 3.0), 0.35 * sideways);
  EXPECT_NEAR(parallax_per_frame(walk(5, 0.03, 0.01)), sideways, 0.1 * sideways);
  EXPECT_NEAR(parallax_per_frame(walk(5, 0, 0.01)), 0, 1e-9);
  EXPECT_EQ(parallax_per_frame(walk(1, 1, 0)), 0);
  EXPECT_EQ(parallax_per_frame(SfmResult{}), 0);
}

TEST(SceneChoices, SharesOfMasks) {
  ForegroundMask half(4, 2);
  for (int x = 0; x < 4; ++x) half(x, 0) = 1;
  const std::vector<ForegroundMask> masks = {half, ForegroundMask(4, 2)};
  EXPECT_DOUBLE_EQ(mean_share(masks), 0.25);
  EXPECT_EQ(mean_share({}), 0);
}

}  // namespace
}  // namespace uwv::pipeline
