// SPDX-License-Identifier: Apache-2.0
// Clips at the edge of what can be solved: each ends in a right answer or in a refusal that names its reason.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "geometry/sfm/clips.h"

namespace uwv::testing {
namespace {

Clip orbit_in_room(int frames, double step_degrees, double fov = 60) {
  StockScene room = boxes_room(small_clip());
  room.source.intrinsics = Intrinsics::from_fov_x(fov * degree, clip_size);
  return film(room, frames, [&](int i, const Camera& source) {
    return orbit_camera(source, room.subject_in_world, step_degrees * degree * i);
  });
}

/// `frames` of the clip, in this order.
Clip cut_from(const Clip& clip, const std::vector<std::size_t>& frames) {
  Clip out;
  for (const std::size_t f : frames) {
    out.frames.push_back(clip.frames[f]);
    out.truth.push_back(clip.truth[f]);
  }
  return out;
}

void expect_solved(const SfmResult& result, const Clip& clip, double share, const char* what) {
  ASSERT_EQ(result.motion, ClipMotion::moving) << what << ": " << result.brief();
  EXPECT_EQ(std::count(result.registered.begin(), result.registered.end(), 1), std::ssize(clip.frames)) << what;
  const TrajectoryError error = error_of(result, clip);
  EXPECT_LT(error.ate_rmse, share * error.truth_length) << what << ": " << result.brief();
}

TEST(SfmExtremes, LensesFromTenToAHundredAndFiftyDegrees) {
  for (const double fov : {10.0, 30.0, 90.0, 120.0, 150.0}) {
    const Clip clip = orbit_in_room(12, fov < 20 ? 0.4 : 1.5, fov);
    expect_solved(solve(clip, with_lens(clip)), clip, fov < 20 ? 0.15 : 0.03, fmt::format("{}", fov).c_str());
  }
}

TEST(SfmExtremes, DepthsFromThousandthsToTenThousands) {
  StockOptions near_options = small_clip(), far_options = small_clip();
  near_options.unit = 1e-3;
  far_options.unit = 1e4;
  StockScene scene = slanted_planes(near_options);
  std::erase_if(scene.scene.objects, [](const SceneObject& object) { return object.name == "wall"; });
  for (const SceneObject& object : textured_plane(far_options).scene.objects) scene.scene.objects.push_back(object);
  const Clip clip = film(scene, 12, [](int i, const Camera& source) { return moved(source, {5e-5 * i, 0, 0}); });
  const SfmResult result = solve(clip, with_lens(clip));
  ASSERT_EQ(result.motion, ClipMotion::moving) << result.brief();
  const TrajectoryError error = error_of(result, clip);
  EXPECT_LT(error.ate_rmse, 0.03 * error.truth_length) << result.brief();
  for (const ScenePoint& point : result.points) ASSERT_TRUE(point.x_in_world.allFinite());
}

TEST(SfmExtremes, TwoEqualFramesAreStill) {
  const Clip clip = cut_from(orbit_in_room(1, 0), {0, 0});
  EXPECT_EQ(solve(clip).motion, ClipMotion::still);
}

TEST(SfmExtremes, BlackFramesInTheMiddleAreCutsAndTheLongerPartIsSolved) {
  Clip clip = orbit_in_room(14, 1.2);
  for (const std::size_t f : {3U, 4U}) clip.frames[f] = ImageRgb(clip_size);
  const SfmResult result = solve(clip, with_lens(clip));
  EXPECT_EQ(result.cuts, (std::vector<int>{3, 5}));
  ASSERT_EQ(result.motion, ClipMotion::moving) << result.brief();
  for (std::size_t f = 0; f < 14; ++f) {
    EXPECT_EQ(result.in_shot[f], f < 5 ? 0 : 1) << f;
    EXPECT_EQ(result.registered[f], result.in_shot[f]) << f;
  }
  const Camera& first = result.cameras[5];
  EXPECT_TRUE(first.world_from_cam.translation.isZero(1e-9));
}

TEST(SfmExtremes, AHeldPictureGetsOnePose) {
  const Clip clip = cut_from(orbit_in_room(10, 1.2), {0, 1, 2, 3, 4, 4, 4, 4, 4, 5, 6, 7, 8, 9});
  const SfmResult result = solve(clip, with_lens(clip));
  expect_solved(result, clip, 0.01, "held");
  const double step =
      (result.cameras[9].world_from_cam.translation - result.cameras[8].world_from_cam.translation).norm();
  for (std::size_t f = 5; f <= 8; ++f)
    EXPECT_LT((result.cameras[f].world_from_cam.translation - result.cameras[4].world_from_cam.translation).norm(),
              0.1 * step);
}

TEST(SfmExtremes, StillAtFirstThenMoving) {
  std::vector<std::size_t> frames(10, 0);
  for (std::size_t i = 1; i < 11; ++i) frames.push_back(i);
  const Clip clip = cut_from(orbit_in_room(11, 1.2), frames);
  expect_solved(solve(clip, with_lens(clip)), clip, 0.01, "still, then moving");
}

TEST(SfmExtremes, ALoopEndsWhereItBegan) {
  const StockScene room = boxes_room(small_clip());
  const Clip clip = film(room, 25, [](int i, const Camera& source) {
    const double angle = 15 * degree * i;
    return moved(source, {0.25 * std::sin(angle), 0.25 * (1 - std::cos(angle)), 0});
  });
  const SfmResult result = solve(clip, with_lens(clip));
  expect_solved(result, clip, 0.01, "loop");
  const double scale = error_of(result, clip).truth_from_estimate.scale;
  EXPECT_LT(scale * result.cameras.back().world_from_cam.translation.norm(), 0.02);
}

TEST(SfmExtremes, AThousandSmallFrames) {
  StockOptions options;
  options.size = {160, 120};
  const StockScene room = boxes_room(options);
  const Clip once = film(room, 50, [&](int i, const Camera& source) {
    return orbit_camera(source, room.subject_in_world, 0.6 * degree * i);
  });
  std::vector<std::size_t> there_and_back;
  for (std::size_t i = 0; i < 1000; ++i) there_and_back.push_back(i / 49 % 2 == 0 ? i % 49 : 49 - i % 49);
  const Clip clip = cut_from(once, there_and_back);
  const SfmResult result = solve(clip, with_lens(clip));
  expect_solved(result, clip, 0.001, "a thousand");
}

}  // namespace
}  // namespace uwv::testing
