// SPDX-License-Identifier: Apache-2.0
// Cameras that move through static scenes: the poses found against the poses filmed from.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/sfm/clips.h"

namespace uwv::testing {
namespace {

using Eigen::Vector3d;

Clip orbit_in_room() {
  const StockScene room = boxes_room(small_clip());
  return film(room, 14, [&](int i, const Camera& source) {
    return orbit_camera(source, room.subject_in_world, 1.2 * degree * i);
  });
}

TEST(StructureFromMotion, FindsAnOrbitWithTheLensGiven) {
  const Clip clip = orbit_in_room();
  const SfmResult result = solve(clip, with_lens(clip));
  ASSERT_EQ(result.motion, ClipMotion::moving) << result.brief();
  const TrajectoryError error = error_of(result, clip);
  EXPECT_LT(error.ate_rmse, 0.01 * error.truth_length) << result.brief();
  EXPECT_LT(error.rotation_max, 0.3);
  EXPECT_LT(result.rms_error_px, 0.7);
  EXPECT_FALSE(result.focal_estimated);
  EXPECT_EQ(result.cameras.front().intrinsics, clip.truth.front().intrinsics);
  for (const auto registered : result.registered) EXPECT_EQ(registered, 1);
}

TEST(StructureFromMotion, TracksDoNotDrift) {
  const Clip clip = orbit_in_room();
  const SfmResult result = solve(clip, with_lens(clip));
  const TrajectoryError error = error_of(result, clip);
  EXPECT_LT(error.ate_rmse, 0.0005 * error.truth_length) << result.brief();
}

TEST(StructureFromMotion, PointsLieOnTheScene) {
  const StockScene room = boxes_room(small_clip());
  const Clip clip = orbit_in_room();
  const SfmResult result = solve(clip, with_lens(clip));
  ASSERT_GT(result.points.size(), 100U);
  ThreadPool pool;
  const DepthMap depth = render(room.scene, clip.truth.front(), 0, pool).depth;
  const double scale = error_of(result, clip).truth_from_estimate.scale;
  int seen = 0, near = 0;
  for (const ScenePoint& point : result.points) {
    EXPECT_GE(point.observations.size(), 2U);
    if (point.observations.front().frame != 0) continue;
    const Eigen::Vector2d& pixel = point.observations.front().pixel;
    const double truth = static_cast<double>(depth(static_cast<int>(pixel.x()), static_cast<int>(pixel.y())));
    ++seen;
    if (std::abs(scale * point.x_in_world.z() - truth) < 0.05 * truth) ++near;
  }
  EXPECT_GT(seen, 50);
  EXPECT_GT(near, 0.85 * seen);  // the rest sits on depth edges, where a pixel has two depths
}

TEST(StructureFromMotion, ScaleAndWorldAreAsPromised) {
  const Clip clip = orbit_in_room();
  const SfmResult result = solve(clip, with_lens(clip));
  EXPECT_TRUE(result.cameras.front().world_from_cam.translation.isZero(1e-9));
  EXPECT_TRUE(result.cameras.front().world_from_cam.rotation.isIdentity(1e-9));
  std::vector<double> depths;
  for (const ScenePoint& point : result.points)
    if (point.observations.front().frame == 0) depths.push_back(point.x_in_world.z());
  std::sort(depths.begin(), depths.end());
  ASSERT_FALSE(depths.empty());
  EXPECT_NEAR(depths[depths.size() / 2], 1, 0.05);
}

TEST(StructureFromMotion, EstimatesTheFocalLength) {
  const Clip clip = orbit_in_room();
  const SfmResult result = solve(clip);
  ASSERT_EQ(result.motion, ClipMotion::moving) << result.brief();
  EXPECT_TRUE(result.focal_estimated);
  const double truth = clip.truth.front().intrinsics.fx;
  EXPECT_NEAR(result.cameras.front().intrinsics.fx, truth, 0.12 * truth);
  const TrajectoryError error = error_of(result, clip);
  EXPECT_LT(error.ate_rmse, 0.03 * error.truth_length);
}

TEST(StructureFromMotion, FollowsForwardMotion) {
  const StockScene hall = corridor(small_clip());
  const Clip clip = film(hall, 14, [](int i, const Camera& source) { return moved(source, {0.01 * i, 0, 0.08 * i}); });
  const SfmResult result = solve(clip, with_lens(clip));
  ASSERT_EQ(result.motion, ClipMotion::moving) << result.brief();
  const TrajectoryError error = error_of(result, clip);
  EXPECT_LT(error.ate_rmse, 0.02 * error.truth_length) << result.brief();
  EXPECT_LT(error.rotation_max, 0.5);
}

TEST(StructureFromMotion, TwoFramesAreEnough) {
  const StockScene room = slanted_planes(small_clip());
  const Clip clip = film(room, 2, [](int i, const Camera& source) { return moved(source, {0.15 * i, 0, 0}); });
  const SfmResult result = solve(clip, with_lens(clip));
  ASSERT_EQ(result.motion, ClipMotion::moving) << result.brief();
  ASSERT_EQ(result.cameras.size(), 2U);
  const Vector3d step = result.cameras[1].world_from_cam.translation.normalized();
  EXPECT_GT(step.x(), std::cos(3 * degree)) << step.transpose();
  EXPECT_LT(rotation_angle(result.cameras[1].world_from_cam.rotation, Eigen::Matrix3d::Identity()), 1);
}

TEST(StructureFromMotion, AMovingThingDoesNotBendTheCameras) {
  const StockScene ball = moving_ball(small_clip());
  // Upwards: along the ball's own path, its motion would be that of a static thing at another depth.
  const Clip clip = film(ball, 14, [](int i, const Camera& source) { return moved(source, {0, -0.06 * i, 0}); });
  const SfmResult result = solve(clip, with_lens(clip));
  ASSERT_EQ(result.motion, ClipMotion::moving) << result.brief();
  const TrajectoryError error = error_of(result, clip);
  EXPECT_LT(error.ate_rmse, 0.03 * error.truth_length) << result.brief();
  EXPECT_GT(result.moving_share, 0.01);
  EXPECT_LT(result.moving_share, 0.4);
}

TEST(StructureFromMotion, OnePlaneIsSolvedWithTheLensGiven) {
  const StockScene wall = textured_plane(small_clip());
  const Clip clip = film(wall, 12, [&](int i, const Camera& source) {
    return orbit_camera(source, wall.subject_in_world, 2 * degree * i);
  });
  const SfmResult result = solve(clip, with_lens(clip));
  ASSERT_EQ(result.motion, ClipMotion::moving) << result.brief();
  const TrajectoryError error = error_of(result, clip);
  EXPECT_LT(error.ate_rmse, 0.05 * error.truth_length) << result.brief();
}

TEST(StructureFromMotion, OnePlaneWithoutALensIsPosedOrNamed) {
  const StockScene wall = textured_plane(small_clip());
  const Clip clip = film(wall, 10, [&](int i, const Camera& source) {
    return orbit_camera(source, wall.subject_in_world, 2 * degree * i);
  });
  const SfmResult result = solve(clip);
  EXPECT_FALSE(result.reason.empty());
  if (result.motion == ClipMotion::moving) {
    // A plane says little about the lens; directions of motion must come out all the same.
    const TrajectoryError error = error_of(result, clip);
    EXPECT_LT(error.ate_rmse, 0.25 * error.truth_length) << result.brief();
  }
}

TEST(StructureFromMotion, ResultsAreInPixelsOfTheFullPicture) {
  const Clip clip = orbit_in_room();
  SfmOptions options = with_lens(clip);
  options.tracking_height = 180;  // shrinks by 4/3
  const SfmResult result = solve(clip, options);
  ASSERT_EQ(result.motion, ClipMotion::moving) << result.brief();
  EXPECT_NEAR(result.cameras.front().intrinsics.fx, options.intrinsics->fx, 1e-9);
  EXPECT_NEAR(result.cameras.front().intrinsics.cy, options.intrinsics->cy, 1e-9);
  double sum = 0, count = 0;
  for (const ScenePoint& point : result.points)
    for (const PointObservation& seen : point.observations) {
      const Camera& camera = result.cameras[static_cast<std::size_t>(seen.frame)];
      Eigen::Vector2d pixel;
      ASSERT_TRUE(project(camera.intrinsics, camera.cam_from_world() * point.x_in_world, pixel));
      sum += (pixel - seen.pixel).norm();
      ++count;
    }
  ASSERT_GT(count, 0);
  EXPECT_LT(sum / count, 1);
}

TEST(StructureFromMotion, NarrowAndWideLensesWork) {
  for (const double fov : {10.0, 120.0}) {
    StockScene room = boxes_room(small_clip());
    room.source.intrinsics = Intrinsics::from_fov_x(fov * degree, clip_size);
    const Clip clip = film(room, 12, [&](int i, const Camera& source) {
      return orbit_camera(source, room.subject_in_world, (fov < 60 ? 0.4 : 2.0) * degree * i);
    });
    const SfmResult result = solve(clip, with_lens(clip));
    ASSERT_EQ(result.motion, ClipMotion::moving) << fov << ": " << result.brief();
    const TrajectoryError error = error_of(result, clip);
    EXPECT_LT(error.ate_rmse, (fov < 60 ? 0.15 : 0.03) * error.truth_length) << fov << ": " << result.brief();
  }
}

TEST(StructureFromMotion, AFalseLensNeverReadsAsAPerfectResult) {
  const Clip clip = orbit_in_room();
  SfmOptions options = with_lens(clip);
  options.intrinsics->fx *= 4;
  options.intrinsics->fy *= 4;
  const SfmResult wrong = solve(clip, options), right = solve(clip, with_lens(clip));
  EXPECT_FALSE(wrong.reason.empty());
  if (wrong.motion == ClipMotion::moving) {
    EXPECT_GT(wrong.rms_error_px, 1.2 * right.rms_error_px);
  }
}

}  // namespace
}  // namespace uwv::testing
