// SPDX-License-Identifier: Apache-2.0
// Depth from several views at the edges of what may be asked: units, offsets, sizes, nothing to see, nobody to ask.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "geometry/mvs/clip.h"

namespace uwv {
namespace {

using test::Clip;

struct Outcome {
  std::vector<FrameGeometry> frames;
  MvsSummary summary;
};

Outcome run(const Clip& clip, const std::vector<ValidityMask>& masks = {}, const MvsOptions& options = {}) {
  ThreadPool pool(2);
  Monitor monitor;
  Outcome out;
  out.summary = multi_view_stereo(clip.frames, clip.cameras, clip.points, masks, options, pool, monitor, out.frames);
  return out;
}

Clip room(StockOptions options, int count = 5, double degrees = 8) {
  ThreadPool pool(2);
  return test::orbit_clip(boxes_room(options), count, degrees, pool);
}

Clip small_room() { return room(test::small_scene({160, 96})); }

/// The same pictures in another unit.
Clip scaled(Clip clip, double unit) {
  for (Camera& camera : clip.cameras) camera.world_from_cam.translation *= unit;
  for (ScenePoint& point : clip.points) point.x_in_world *= unit;
  for (DepthMap& depth : clip.truth)
    for (float& z : depth.pixels()) z = static_cast<float>(z * unit);
  return clip;
}

double share_that_differs(const FrameGeometry& a, const FrameGeometry& b, double unit, double tolerance) {
  double off = 0;
  for (std::size_t i = 0; i < a.depth.size().pixels(); ++i)
    if (!(std::abs(a.depth.data()[i] * unit - b.depth.data()[i]) <= tolerance * a.depth.data()[i] * unit)) ++off;
  return off / static_cast<double>(a.depth.size().pixels());
}

void expect_well_formed(const Outcome& result, Size size) {
  for (const FrameGeometry& frame : result.frames) EXPECT_TRUE(test::well_formed(frame, size));
}

void expect_nothing_known(const Outcome& result) {
  EXPECT_EQ(result.summary.measured_share, 0);
  for (const FrameGeometry& frame : result.frames)
    for (const float z : frame.depth.pixels()) ASSERT_EQ(z, 0);
}

class AnyUnit : public testing::TestWithParam<double> {};

TEST_P(AnyUnit, GivesTheSamePictureScaled) {
  const Clip clip = small_room();
  const Outcome plain = run(clip);
  const Outcome other = run(scaled(clip, GetParam()));
  ASSERT_GT(plain.summary.measured_share, 0.5);
  // Roundings of the last bit move a tie between planes here and there.
  for (std::size_t i = 0; i < clip.frames.size(); ++i)
    EXPECT_LT(share_that_differs(plain.frames[i], other.frames[i], GetParam(), 1e-4), 2e-3) << "frame " << i;
}
INSTANTIATE_TEST_SUITE_P(Units, AnyUnit, testing::Values(1e-6, 1e-3, 1e6, 1e9));

TEST(MultiViewStereoExtremes, APowerOfTwoAsUnitChangesNoBit) {
  const Clip clip = small_room();
  const Outcome plain = run(clip);
  const Outcome other = run(scaled(clip, 1024));
  for (std::size_t i = 0; i < clip.frames.size(); ++i)
    EXPECT_EQ(share_that_differs(plain.frames[i], other.frames[i], 1024, 0), 0) << "frame " << i;
}

TEST(MultiViewStereoExtremes, TheWorldsOriginMayBeFarAway) {
  Clip clip = small_room();
  const Outcome plain = run(clip);
  const Eigen::Vector3d away(1e7, -1e7, 1e7);
  for (Camera& camera : clip.cameras) camera.world_from_cam.translation += away;
  for (ScenePoint& point : clip.points) point.x_in_world += away;
  const Outcome far = run(clip);
  // At 1e7, a double steps by 2e-9, and baselines of 0.1 are uncertain by 2e-8 of their length: hundreds of times what
  // is left of a change of unit. More ties between planes, and depths at the limits of agreement, turn over.
  for (std::size_t i = 0; i < clip.frames.size(); ++i)
    EXPECT_LT(share_that_differs(plain.frames[i], far.frames[i], 1, 1e-4), 1e-2) << "frame " << i;
  EXPECT_NEAR(test::mean_error(far.frames, clip.truth).rel_all, test::mean_error(plain.frames, clip.truth).rel_all,
              1e-4);
}

TEST(MultiViewStereoExtremes, OneFrameHasNobodyToAsk) {
  Clip clip = small_room();
  clip.frames.resize(1);
  clip.cameras.resize(1);
  const Outcome result = run(clip);
  expect_nothing_known(result);
  EXPECT_THAT(result.summary.notes, testing::Contains(testing::HasSubstr("one frame")));
}

TEST(MultiViewStereoExtremes, CamerasAtOnePlaceSeeNoDepth) {
  Clip clip = small_room();
  for (Camera& camera : clip.cameras) camera = clip.cameras.front();
  const Outcome result = run(clip);
  expect_nothing_known(result);
  EXPECT_EQ(result.summary.matched_frames, 0);
  EXPECT_THAT(result.summary.notes, testing::Contains(testing::HasSubstr("parallax")));
}

TEST(MultiViewStereoExtremes, WithoutPointsTheRangeIsGuessed) {
  Clip clip = small_room();
  clip.points.clear();
  const Outcome result = run(clip);
  expect_well_formed(result, clip.frames.front().size());
  EXPECT_THAT(result.summary.notes, testing::Contains(testing::HasSubstr("no sparse points")));
  EXPECT_LT(test::mean_error(result.frames, clip.truth).rel_measured, 0.05);
}

TEST(MultiViewStereoExtremes, PointsThatAreNotFiniteAreIgnored) {
  Clip clip = small_room();
  const Outcome plain = run(clip);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  ScenePoint bad;
  for (const Eigen::Vector3d& x :
       {Eigen::Vector3d(nan, 0, 1), Eigen::Vector3d(0, inf, 1), Eigen::Vector3d(0, 0, -inf)}) {
    bad.x_in_world = x;
    clip.points.push_back(bad);
  }
  const Outcome result = run(clip);
  for (std::size_t i = 0; i < clip.frames.size(); ++i) EXPECT_TRUE(plain.frames[i].depth == result.frames[i].depth);
}

TEST(MultiViewStereoExtremes, EvenPicturesAreNotMeasured) {
  Clip clip = small_room();
  for (ImageRgb& frame : clip.frames) frame.fill({90, 120, 60});
  const Outcome result = run(clip);
  expect_well_formed(result, clip.frames.front().size());
  EXPECT_EQ(result.summary.measured_share, 0);
}

TEST(MultiViewStereoExtremes, NoiseIsHardlyMeasured) {
  Clip clip = small_room();
  std::mt19937 random(3);
  for (ImageRgb& frame : clip.frames)
    for (Rgb8& p : frame.pixels()) p.r = p.g = p.b = static_cast<std::uint8_t>(random() % 256);
  const Outcome result = run(clip);
  expect_well_formed(result, clip.frames.front().size());
  EXPECT_LT(result.summary.measured_share, 0.15);
}

TEST(MultiViewStereoExtremes, AnySizeWorks) {
  for (const Size size : {Size{1, 1}, Size{1, 7}, Size{9, 1}, Size{2, 2}, Size{33, 17}, Size{101, 3}}) {
    for (const double scale : {0.01, 0.5, 1.0}) {
      MvsOptions options;
      options.scale = scale;
      options.planes = 9;
      const Clip clip = room(test::small_scene(size), 3);
      expect_well_formed(run(clip, {}, options), size);
    }
  }
}

TEST(MultiViewStereoExtremes, MovingPixelsStayUnknown) {
  const Clip clip = small_room();
  const Size size = clip.frames.front().size();
  std::vector<ValidityMask> masks(clip.frames.size(), ValidityMask(size, 1));
  for (ValidityMask& mask : masks)
    for (int y = 30; y < 60; ++y)
      for (int x = 50; x < 90; ++x) mask(x, y) = 0;
  const Outcome result = run(clip, masks);
  expect_well_formed(result, size);
  for (const FrameGeometry& frame : result.frames) {
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x)
        ASSERT_EQ(frame.depth(x, y) == 0, y >= 30 && y < 60 && x >= 50 && x < 90) << x << ", " << y;
  }
}

TEST(MultiViewStereoExtremes, WhatMovingPixelsShowDoesNotMatter) {
  Clip clip = small_room();
  const Size size = clip.frames.front().size();
  std::vector<ValidityMask> masks(clip.frames.size(), ValidityMask(size, 1));
  for (ValidityMask& mask : masks)
    for (int y = 30; y < 60; ++y)
      for (int x = 50; x < 90; ++x) mask(x, y) = 0;
  const double before = test::mean_error(run(clip, masks).frames, clip.truth).rel_all;
  std::mt19937 random(5);
  for (ImageRgb& frame : clip.frames)
    for (int y = 32; y < 58; ++y)
      for (int x = 52; x < 88; ++x)
        frame(x, y) = {static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()), 0};
  EXPECT_LT(test::mean_error(run(clip, masks).frames, clip.truth).rel_all, 1.2 * before + 0.002);
}

TEST(MultiViewStereoExtremes, MasksMayBeEmptyOrForbidEverything) {
  const Clip clip = small_room();
  const Size size = clip.frames.front().size();
  const Outcome plain = run(clip);
  const Outcome empty = run(clip, std::vector<ValidityMask>(clip.frames.size()));
  for (std::size_t i = 0; i < clip.frames.size(); ++i) EXPECT_TRUE(plain.frames[i].depth == empty.frames[i].depth);
  expect_nothing_known(run(clip, std::vector<ValidityMask>(clip.frames.size(), ValidityMask(size, 0))));
  std::vector<ValidityMask> single(clip.frames.size(), ValidityMask(size, 0));
  for (ValidityMask& mask : single) mask(70, 40) = 1;
  expect_well_formed(run(clip, single), size);
}

class StopAt : public Monitor {
 public:
  explicit StopAt(int calls) : calls_(calls) {}
  bool progress(std::string_view, long, long) override { return --calls_ > 0; }

 private:
  int calls_;
};

TEST(MultiViewStereoExtremes, StopsWhenToldTo) {
  const Clip clip = small_room();
  ThreadPool pool(2);
  for (const int calls : {1, 2, 4}) {
    StopAt monitor(calls);
    std::vector<FrameGeometry> out;
    try {
      multi_view_stereo(clip.frames, clip.cameras, clip.points, {}, {}, pool, monitor, out);
      FAIL() << "not stopped at call " << calls;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::cancelled);
    }
  }
}

TEST(MultiViewStereoExtremes, RefusesWhatDoesNotFit) {
  const Clip clip = small_room();
  Clip wrong = clip;
  wrong.cameras.pop_back();
  EXPECT_THROW(run(wrong), std::invalid_argument);
  wrong = clip;
  wrong.frames[1] = ImageRgb(8, 8);
  EXPECT_THROW(run(wrong), std::invalid_argument);
  wrong = clip;
  wrong.cameras[2].intrinsics.fx = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(run(wrong), std::invalid_argument);
  wrong = clip;
  wrong.cameras[2].world_from_cam.translation.x() = std::numeric_limits<double>::infinity();
  EXPECT_THROW(run(wrong), std::invalid_argument);
  EXPECT_THROW(run(clip, std::vector<ValidityMask>(2)), std::invalid_argument);
  EXPECT_THROW(run(clip, std::vector<ValidityMask>(clip.frames.size(), ValidityMask(3, 3, 1))), std::invalid_argument);
  EXPECT_THROW(run(Clip{}), std::invalid_argument);
}

TEST(MultiViewStereoExtremes, RefusesOptionsOutOfRange) {
  const auto refuses = [](auto change) {
    MvsOptions options;
    change(options);
    EXPECT_THROW(options.check(), std::invalid_argument);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refuses([](MvsOptions& o) { o.neighbours = 0; });
  refuses([](MvsOptions& o) { o.planes = 3; });
  refuses([](MvsOptions& o) { o.planes = 5000; });
  refuses([](MvsOptions& o) { o.scale = 0; });
  refuses([](MvsOptions& o) { o.scale = 1.5; });
  refuses([&](MvsOptions& o) { o.scale = nan; });
  refuses([](MvsOptions& o) { o.key_stride = -1; });
  refuses([](MvsOptions& o) { o.consistency = 0; });
  refuses([&](MvsOptions& o) { o.consistency = nan; });
  EXPECT_NO_THROW(MvsOptions{}.check());
}

}  // namespace
}  // namespace uwv
