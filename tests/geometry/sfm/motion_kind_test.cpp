// SPDX-License-Identifier: Apache-2.0
// What cannot be reconstructed is named, not invented; and the promises about threads, seeds, cuts and callers' errors.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "geometry/sfm/clips.h"

namespace uwv::testing {
namespace {

Clip orbit(int frames) {
  const StockScene room = boxes_room(small_clip());
  return film(room, frames, [&](int i, const Camera& source) {
    return orbit_camera(source, room.subject_in_world, 1.2 * degree * i);
  });
}

TEST(MotionKind, TurningIsNamedAndItsRotationsFound) {
  const StockScene room = boxes_room(small_clip());
  const Clip clip = film(room, 12, [](int i, const Camera& source) {
    return moved(source, {0, 0, 0}, 1.0 * degree * i);
  });
  for (const bool known : {true, false}) {
    const SfmResult result = solve(clip, known ? with_lens(clip) : SfmOptions{});
    ASSERT_EQ(result.motion, ClipMotion::turning) << result.brief();
    EXPECT_TRUE(result.points.empty());
    const TrajectoryError error = error_of(result, clip);
    EXPECT_LT(error.rotation_max, known ? 0.1 : 1.5) << result.brief();
    for (const Camera& camera : result.cameras) EXPECT_TRUE(camera.world_from_cam.translation.isZero(1e-12));
  }
}

TEST(MotionKind, StillIsNamed) {
  const Clip clip = film(moving_ball(small_clip()), 8, [](int, const Camera& source) { return source; });
  const SfmResult result = solve(clip);
  ASSERT_EQ(result.motion, ClipMotion::still) << result.brief();
  ASSERT_EQ(result.cameras.size(), 8U);
  for (const Camera& camera : result.cameras) EXPECT_EQ(camera.world_from_cam, Rigid3{});
}

/// `patch` laid over the picture, shifted to the right.
void lay_over(ImageRgb& frame, const ImageRgb& patch, int left, int top, int width, int height, int shift) {
  for (int y = top; y < top + height; ++y)
    for (int x = left; x < left + width; ++x) frame(x, y) = patch((x - shift + 10 * patch.width()) % patch.width(), y);
}

TEST(MotionKind, ACrowdBeforeALockedOffCameraIsStill) {
  // Six tenths of the picture pass by; the rest, all around, stands.
  const Clip room = film(boxes_room(small_clip()), 1, [](int, const Camera& source) { return source; });
  const Clip other = film(slanted_planes(small_clip()), 1, [](int, const Camera& source) { return source; });
  Clip clip;
  for (int i = 0; i < 12; ++i) {
    clip.frames.push_back(other.frames[0]);
    lay_over(clip.frames.back(), room.frames[0], 36, 27, 248, 186, 3 * i);
  }
  const SfmResult result = solve(clip);
  EXPECT_EQ(result.motion, ClipMotion::still) << result.brief();
}

TEST(MotionKind, AStripLaidOverTheClipDoesNotMakeItStill) {
  Clip clip = orbit(12);
  const Clip other = film(slanted_planes(small_clip()), 1, [](int, const Camera& source) { return source; });
  for (ImageRgb& frame : clip.frames) lay_over(frame, other.frames[0], 0, 190, 320, 50, 0);
  const SfmResult result = solve(clip, with_lens(clip));
  EXPECT_EQ(result.motion, ClipMotion::moving) << result.brief();
}

TEST(MotionKind, OneFrameIsStillWithAReason) {
  const Clip clip = orbit(1);
  const SfmResult result = solve(clip);
  EXPECT_EQ(result.motion, ClipMotion::still);
  EXPECT_FALSE(result.reason.empty());
  EXPECT_EQ(result.in_shot, std::vector<std::uint8_t>{1});
  ASSERT_EQ(result.cameras.size(), 1U);
  EXPECT_EQ(result.cameras[0].size, clip_size);
}

TEST(MotionKind, NothingToTrackIsIndeterminate) {
  for (const Size size : {Size{320, 240}, Size{16, 9}, Size{1, 1}, Size{2000, 3}}) {
    Clip clip;
    clip.frames.assign(5, ImageRgb(size));
    const SfmResult result = solve(clip);
    EXPECT_EQ(result.motion, ClipMotion::indeterminate);
    EXPECT_TRUE(result.cameras.empty());
    EXPECT_EQ(result.in_shot.size(), 5U);
    EXPECT_NE(result.reason.find("features"), std::string::npos) << result.reason;
  }
}

TEST(MotionKind, FlickerOfNoiseIsNoCameraPath) {
  Clip clip;
  std::uint32_t state = 1;
  for (int f = 0; f < 6; ++f) {
    ImageRgb frame(clip_size);
    for (Rgb8& p : frame.pixels()) {
      state = state * 1664525U + 1013904223U;
      const auto v = static_cast<std::uint8_t>(state >> 24);
      p = {v, v, v};
    }
    clip.frames.push_back(std::move(frame));
  }
  const SfmResult result = solve(clip);
  EXPECT_NE(result.motion, ClipMotion::moving) << result.brief();
}

TEST(MotionKind, ACutIsFoundAndTheLongestShotPosed) {
  Clip clip = orbit(12);
  const StockScene planes = slanted_planes(small_clip());
  const Clip other = film(planes, 4, [](int i, const Camera& source) { return moved(source, {0.05 * i, 0, 0}); });
  const SfmOptions options = with_lens(clip);
  clip.frames.insert(clip.frames.begin(), other.frames.begin(), other.frames.end());
  const SfmResult result = solve(clip, options);
  EXPECT_EQ(result.cuts, std::vector<int>{4});
  ASSERT_EQ(result.motion, ClipMotion::moving) << result.brief();
  ASSERT_EQ(result.cameras.size(), 16U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(result.registered[i], 0);
    EXPECT_EQ(result.in_shot[i], 0);
    EXPECT_EQ(result.cameras[i], result.cameras[4]);  // the shot's nearest camera
  }
  EXPECT_EQ(result.registered[4], 1);
  EXPECT_EQ(std::count(result.in_shot.begin() + 4, result.in_shot.end(), 1), 12);
  for (const ScenePoint& point : result.points)
    for (const PointObservation& seen : point.observations) ASSERT_GE(seen.frame, 4);
}

TEST(MotionKind, ThreadsChangeNothing) {
  const Clip clip = orbit(8);
  const SfmResult one = solve(clip, {}, 1), three = solve(clip, {}, 3);
  ASSERT_EQ(one.cameras.size(), three.cameras.size());
  EXPECT_EQ(one.cameras, three.cameras);
  ASSERT_EQ(one.points.size(), three.points.size());
  for (std::size_t i = 0; i < one.points.size(); ++i) ASSERT_EQ(one.points[i].x_in_world, three.points[i].x_in_world);
}

TEST(MotionKind, AnotherSeedDrawsOtherSamplesForTheSameCameras) {
  const Clip clip = orbit(10);
  SfmOptions options = with_lens(clip);
  const SfmResult one = solve(clip, options);
  options.seed = 7;
  const SfmResult seven = solve(clip, options);
  ASSERT_EQ(one.motion, ClipMotion::moving) << one.brief();
  ASSERT_EQ(seven.motion, ClipMotion::moving) << seven.brief();
  EXPECT_NE(one.cameras, seven.cameras);  // the last digits tell where each came from
  for (const SfmResult* result : {&one, &seven}) {
    const TrajectoryError error = error_of(*result, clip);
    EXPECT_LT(error.ate_rmse, 0.02 * error.truth_length);
  }
}

struct Stopper : Monitor {
  std::string_view at;
  explicit Stopper(std::string_view stage) : at(stage) {}
  bool progress(std::string_view stage, long, long) override { return stage != at; }
};

TEST(MotionKind, EveryStageStopsWhenAsked) {
  const Clip clip = orbit(6);
  ThreadPool pool(2);
  for (const char* stage : {"tracking", "cameras", "bundle adjustment"}) {
    Stopper monitor(stage);
    try {
      structure_from_motion(clip.frames, with_lens(clip), pool, monitor);
      ADD_FAILURE() << "not stopped in " << stage;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::cancelled);
    }
  }
}

TEST(MotionKind, CallersMistakesAreRefused) {
  ThreadPool pool(1);
  Monitor monitor;
  EXPECT_THROW(structure_from_motion({}, {}, pool, monitor), std::invalid_argument);
  const std::vector<ImageRgb> mixed{ImageRgb(64, 64), ImageRgb(64, 65)};
  EXPECT_THROW(structure_from_motion(mixed, {}, pool, monitor), std::invalid_argument);
  SfmOptions options;
  options.max_error_px = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(options.check(), std::invalid_argument);
  options = {};
  options.intrinsics = Intrinsics{0, 100, 50, 50};
  EXPECT_THROW(options.check(), std::invalid_argument);
}

}  // namespace
}  // namespace uwv::testing
