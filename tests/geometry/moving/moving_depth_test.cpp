// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/moving/orbiting_clip.h"
#include "uwv/core/depth.h"
#include "uwv/geometry/moving_objects.h"

namespace uwv::testing {
namespace {

/// 0 where the clip's object `mover` is.
std::vector<ValidityMask> exact_masks(const OrbitingClip& clip, int mover) {
  std::vector<ValidityMask> masks;
  for (const auto& object : clip.object) {
    ValidityMask& mask = masks.emplace_back(object.size(), std::uint8_t{1});
    for (std::size_t p = 0; p < mask.pixels().size(); ++p)
      if (object.pixels()[p] == mover) mask.pixels()[p] = 0;
  }
  return masks;
}

/// Mean relative error of the depth of masked pixels that belong to `mover`.
double mean_error(const std::vector<FrameGeometry>& got, const std::vector<ValidityMask>& masks,
                  const OrbitingClip& clip, int mover) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < got.size(); ++i)
    for (std::size_t p = 0; p < masks[i].pixels().size(); ++p)
      if (masks[i].pixels()[p] == 0 && clip.object[i].pixels()[p] == mover) {
        const double truth = clip.truth[i].depth.pixels()[p];
        sum += std::abs(got[i].depth.pixels()[p] - truth) / truth;
        count += 1;
      }
  return count > 0 ? sum / count : 0;
}

/// Without what MVS would not know: depth of the masked pixels.
std::vector<FrameGeometry> forget_moving(std::vector<FrameGeometry> geometry, const std::vector<ValidityMask>& masks) {
  for (std::size_t i = 0; i < geometry.size(); ++i)
    for (std::size_t p = 0; p < masks[i].pixels().size(); ++p)
      if (masks[i].pixels()[p] == 0) geometry[i].depth.pixels()[p] = 0, geometry[i].confidence.pixels()[p] = 0;
  return geometry;
}

class MovingDepthTest : public ::testing::Test {
 protected:
  OrbitingClip ball(double degrees, double unit, int frames = 7) {
    StockOptions stock;
    stock.size = {416, 240};
    stock.unit = unit;
    return orbiting_clip(moving_ball(stock), frames, degrees, 0.5, pool_);
  }
  MovingDepthSummary fill(const OrbitingClip& clip, const std::vector<ValidityMask>& masks,
                          std::vector<FrameGeometry>& geometry) {
    return fill_moving_depth(clip.frames, clip.cameras, masks, {}, pool_, monitor_, geometry);
  }
  ThreadPool pool_{2};
  Monitor monitor_;
};

TEST_F(MovingDepthTest, PutsTheBallWhereItTouchesTheFloorAtAnyScale) {
  for (const double unit : {1.0, 1e-6, 1e9}) {
    const OrbitingClip clip = ball(6, unit, 4);
    const std::vector<ValidityMask> masks = exact_masks(clip, 0);
    std::vector<FrameGeometry> geometry = forget_moving(clip.truth, masks);
    const std::vector<FrameGeometry> before = geometry;
    const MovingDepthSummary summary = fill(clip, masks, geometry);
    EXPECT_LT(mean_error(geometry, masks, clip, 0), 0.08) << "unit " << unit;
    EXPECT_EQ(summary.objects.size(), 1U);
    EXPECT_EQ(summary.contact_share, 1.0);
    for (std::size_t i = 0; i < geometry.size(); ++i)
      for (std::size_t p = 0; p < masks[i].pixels().size(); ++p) {
        const bool moves = masks[i].pixels()[p] == 0;
        if (moves) {
          EXPECT_TRUE(is_valid_depth(geometry[i].depth.pixels()[p]));
          EXPECT_EQ(geometry[i].confidence.pixels()[p], 0.3F);
        } else {
          ASSERT_EQ(geometry[i].depth.pixels()[p], before[i].depth.pixels()[p]);
          ASSERT_EQ(geometry[i].confidence.pixels()[p], before[i].confidence.pixels()[p]);
        }
      }
  }
}

TEST_F(MovingDepthTest, ABallInTwoPartsIsOneObjectOnOneFoot) {
  const OrbitingClip clip = ball(6, 1, 6);
  std::vector<ValidityMask> masks = exact_masks(clip, 0);
  for (std::size_t i = 0; i < masks.size(); ++i) {
    // A band across the ball was not found to move.
    int top = masks[i].height(), bottom = 0;
    for (int y = 0; y < masks[i].height(); ++y)
      for (int x = 0; x < masks[i].width(); ++x)
        if (masks[i](x, y) == 0) top = std::min(top, y), bottom = std::max(bottom, y);
    for (int y = (top + bottom) / 2 - 3; y < (top + bottom) / 2 + 3; ++y)
      for (int x = 0; x < masks[i].width(); ++x) masks[i](x, y) = 1;
  }
  std::vector<FrameGeometry> geometry = forget_moving(clip.truth, masks);
  const MovingDepthSummary summary = fill(clip, masks, geometry);
  EXPECT_EQ(summary.objects.size(), 1U);
  EXPECT_LT(mean_error(geometry, masks, clip, 0), 0.1);
}

TEST_F(MovingDepthTest, AMissingFootInEverySecondFrameDoesNotMakeTheObjectJump) {
  const OrbitingClip clip = ball(6, 1, 10);
  std::vector<ValidityMask> masks = exact_masks(clip, 0);
  for (std::size_t i = 0; i < masks.size(); i += 2) {
    int bottom = 0;
    for (int y = 0; y < masks[i].height(); ++y)
      for (int x = 0; x < masks[i].width(); ++x)
        if (masks[i](x, y) == 0) bottom = std::max(bottom, y);
    for (int y = bottom - 5; y <= bottom; ++y)
      for (int x = 0; x < masks[i].width(); ++x) masks[i](x, y) = 1;
  }
  std::vector<FrameGeometry> geometry = clip.truth;
  for (std::size_t i = 0; i < geometry.size(); ++i)
    for (std::size_t p = 0; p < masks[i].pixels().size(); ++p)
      if (clip.object[i].pixels()[p] == 0) geometry[i].depth.pixels()[p] = 0, geometry[i].confidence.pixels()[p] = 0;
  const MovingDepthSummary summary = fill(clip, masks, geometry);
  ASSERT_EQ(summary.objects.size(), 1U);
  for (std::size_t i = 1; i < 10; ++i)
    EXPECT_NEAR(summary.objects[0].depths[i] / summary.objects[0].depths[i - 1], 1, 0.02) << "frame " << i;
}

TEST_F(MovingDepthTest, GroundSeenSteeplyFromAboveIsKnownFromOtherFrames) {
  // The camera nods from 20 to 75 degrees down, at a floor; a block of pixels stands on it.
  StockOptions stock;
  stock.size = {160, 120};
  Camera camera;
  camera.size = stock.size;
  camera.intrinsics = Intrinsics::from_fov_x(1, stock.size);
  std::vector<Camera> cameras;
  std::vector<FrameGeometry> geometry;
  std::vector<ValidityMask> masks;
  constexpr int frames = 24;
  for (int i = 0; i < frames; ++i) {
    const double pitch = (20 + 55.0 * i / (frames - 1)) * 3.14159265358979 / 180;
    camera.world_from_cam.rotation = Eigen::AngleAxisd(-pitch, Eigen::Vector3d::UnitX()).toRotationMatrix();
    cameras.push_back(camera);
    FrameGeometry& frame = geometry.emplace_back(FrameGeometry{DepthMap(stock.size), ConfidenceMap(stock.size, 1.0F)});
    ValidityMask& mask = masks.emplace_back(stock.size, std::uint8_t{1});
    for (int y = 0; y < 120; ++y)
      for (int x = 0; x < 160; ++x) {
        const Eigen::Vector3d ray_in_world =
            camera.world_from_cam.rotation * unproject(camera.intrinsics, {x + 0.5, y + 0.5}, 1.0);
        frame.depth(x, y) = ray_in_world.y() > 0.05 ? static_cast<float>(1 / ray_in_world.y()) : 20.0F;
        if (x >= 70 && x < 90 && y >= 40 && y < 80) mask(x, y) = 0;
      }
  }
  const std::vector<FrameGeometry> truth = geometry;
  for (std::size_t i = 0; i < geometry.size(); ++i)
    for (std::size_t p = 0; p < masks[i].pixels().size(); ++p)
      if (masks[i].pixels()[p] == 0) geometry[i].depth.pixels()[p] = 0;
  const MovingDepthSummary summary = fill_moving_depth(std::vector<ImageRgb>(frames, ImageRgb(stock.size)), cameras,
                                                       masks, {.smoothing = 0}, pool_, monitor_, geometry);
  ASSERT_EQ(summary.objects.size(), 1U);
  for (std::size_t i = 0; i < frames; ++i) {
    EXPECT_EQ(summary.objects[0].sources[i], MovingDepthSource::contact) << "frame " << i;
    EXPECT_NEAR(summary.objects[0].depths[i] / truth[i].depth(80, 79), 1, 0.03) << "frame " << i;
    // Leaning is bounded: seen from above, its top does not come at the camera.
    EXPECT_GT(geometry[i].depth(80, 40), 0.8 * summary.objects[0].depths[i]) << "frame " << i;
  }
}

TEST_F(MovingDepthTest, ServesFoundMasksAsWellAsExactOnes) {
  const OrbitingClip clip = ball(3, 1, 5);
  const std::vector<ValidityMask> masks =
      find_moving_pixels(clip.frames, clip.cameras, clip.truth, {}, pool_, monitor_).static_pixels;
  std::vector<FrameGeometry> geometry = forget_moving(clip.truth, masks);
  fill(clip, masks, geometry);
  EXPECT_LT(mean_error(geometry, masks, clip, 0), 0.12);
}

TEST_F(MovingDepthTest, StaysInFrontOfWhatIsBehindIt) {
  const OrbitingClip clip = ball(6, 1);
  const std::vector<ValidityMask> masks = exact_masks(clip, 0);
  std::vector<FrameGeometry> geometry = forget_moving(clip.truth, masks);
  fill(clip, masks, geometry);
  for (std::size_t i = 0; i < geometry.size(); ++i) {
    // The wall is flat: the farthest depth in the picture is nowhere nearer than what is behind the ball's top.
    const auto& all = clip.truth[i].depth.pixels();
    const float wall = *std::max_element(all.begin(), all.end());
    for (std::size_t p = 0; p < masks[i].pixels().size(); ++p)
      if (masks[i].pixels()[p] == 0) {
        ASSERT_LT(geometry[i].depth.pixels()[p], wall);
      }
  }
}

TEST_F(MovingDepthTest, OneFrameOfBadGroundDoesNotMakeTheObjectJump) {
  const OrbitingClip clip = ball(6, 1, 9);
  const std::vector<ValidityMask> masks = exact_masks(clip, 0);
  std::vector<FrameGeometry> geometry = forget_moving(clip.truth, masks);
  for (float& z : geometry[4].depth.pixels()) z *= 1.6F;
  const MovingDepthSummary summary = fill(clip, masks, geometry);
  ASSERT_EQ(summary.objects.size(), 1U);
  EXPECT_EQ(summary.objects[0].sources[4], MovingDepthSource::size);
  for (std::size_t i = 1; i < 9; ++i)
    EXPECT_NEAR(summary.objects[0].depths[i] / summary.objects[0].depths[i - 1], 1, 0.03) << "frame " << i;
}

TEST_F(MovingDepthTest, ContactCutOffByTheBorderIsReplacedByTheChangeOfSize) {
  // The lower half of the last frames' ball is not in the picture.
  OrbitingClip clip = ball(6, 1, 8);
  std::vector<ValidityMask> masks = exact_masks(clip, 0);
  for (std::size_t i = 5; i < 8; ++i)
    for (int y = 0; y < masks[i].height(); ++y)
      for (int x = 0; x < masks[i].width(); ++x) {
        // Nothing below the ball but more of what moves.
        bool above = false;
        for (int v = 0; v <= y && !above; ++v) above = clip.object[i](x, v) == 0;
        if (above) masks[i](x, y) = 0;
      }
  std::vector<FrameGeometry> geometry = forget_moving(clip.truth, masks);
  const MovingDepthSummary summary = fill(clip, masks, geometry);
  ASSERT_EQ(summary.objects.size(), 1U);
  for (std::size_t i = 5; i < 8; ++i) EXPECT_EQ(summary.objects[0].sources[i], MovingDepthSource::size);
  EXPECT_LT(mean_error(geometry, masks, clip, 0), 0.15);
  EXPECT_NEAR(summary.contact_share, 0.5, 0.25);
}

TEST_F(MovingDepthTest, WithoutAnyGroundItIsPutJustInFrontOfTheBackground) {
  StockOptions stock;
  stock.size = {160, 96};
  const OrbitingClip clip = orbiting_clip(textured_plane(stock), 3, 2, 0, pool_);
  std::vector<ValidityMask> masks(3, ValidityMask(stock.size, std::uint8_t{1}));
  for (ValidityMask& mask : masks)
    for (int y = 30; y < 60; ++y)
      for (int x = 70; x < 90; ++x) mask(x, y) = 0;
  std::vector<FrameGeometry> geometry = forget_moving(clip.truth, masks);
  const MovingDepthSummary summary = fill(clip, masks, geometry);
  ASSERT_EQ(summary.objects.size(), 1U);
  EXPECT_EQ(summary.objects[0].sources[0], MovingDepthSource::background);
  EXPECT_LT(geometry[1].depth(80, 45), clip.truth[1].depth(80, 45));
  EXPECT_GT(geometry[1].depth(80, 45), 0.7F * clip.truth[1].depth(80, 45));
  EXPECT_NEAR(geometry[1].confidence(80, 45), 0.1, 1e-6);
  EXPECT_FALSE(summary.notes.empty());
}

TEST_F(MovingDepthTest, WithoutStaticDepthNothingIsInvented) {
  const OrbitingClip clip = ball(0, 1, 3);
  for (const bool all_moving : {false, true}) {
    std::vector<ValidityMask> masks = exact_masks(clip, 0);
    std::vector<FrameGeometry> geometry = clip.truth;
    for (std::size_t i = 0; i < 3; ++i) {
      if (all_moving) masks[i].fill(0);
      if (!all_moving) geometry[i].depth.fill(std::numeric_limits<float>::quiet_NaN());
    }
    const MovingDepthSummary summary = fill(clip, masks, geometry);
    EXPECT_EQ(summary.unknown_share, 1.0);
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t p = 0; p < masks[i].pixels().size(); ++p)
        if (masks[i].pixels()[p] == 0) {
          ASSERT_EQ(geometry[i].depth.pixels()[p], 0);
          ASSERT_EQ(geometry[i].confidence.pixels()[p], 0);
        }
  }
}

TEST_F(MovingDepthTest, SinglePixelsStandOnTheFloorToo) {
  const OrbitingClip clip = ball(6, 1, 3);
  std::vector<ValidityMask> masks(3, ValidityMask(clip.frames[0].size(), std::uint8_t{1}));
  for (ValidityMask& mask : masks) mask(300, 200) = 0, mask(0, 0) = 0, mask(415, 239) = 0;
  std::vector<FrameGeometry> geometry = forget_moving(clip.truth, masks);
  fill(clip, masks, geometry);
  EXPECT_NEAR(geometry[1].depth(300, 200) / clip.truth[1].depth(300, 200), 1, 0.05);
  for (const auto& [x, y] : {std::pair{0, 0}, std::pair{415, 239}})
    EXPECT_TRUE(is_valid_depth(geometry[1].depth(x, y))) << x << ' ' << y;
}

TEST_F(MovingDepthTest, TinyPicturesAndNoFramesAreAnswered) {
  std::vector<FrameGeometry> none;
  EXPECT_TRUE(fill_moving_depth({}, {}, {}, {}, pool_, monitor_, none).objects.empty());
  Camera camera;
  camera.intrinsics = Intrinsics::from_fov_x(1, {1, 1});
  camera.size = {1, 1};
  const std::vector<ImageRgb> frames(2, ImageRgb(1, 1));
  const std::vector<Camera> cameras(2, camera);
  for (const std::uint8_t is_static : {std::uint8_t{0}, std::uint8_t{1}}) {
    std::vector<FrameGeometry> geometry(2, {DepthMap(1, 1, 2.0F), ConfidenceMap(1, 1, 1.0F)});
    const std::vector<ValidityMask> masks(2, ValidityMask(1, 1, is_static));
    fill_moving_depth(frames, cameras, masks, {}, pool_, monitor_, geometry);
    EXPECT_EQ(geometry[0].depth(0, 0), is_static != 0 ? 2.0F : 0.0F);
  }
}

TEST_F(MovingDepthTest, ThreadsDoNotChangeTheResultAndStoppingLeavesDepthAlone) {
  const OrbitingClip clip = ball(6, 1, 4);
  const std::vector<ValidityMask> masks = exact_masks(clip, 0);
  std::vector<FrameGeometry> a = forget_moving(clip.truth, masks), b = a, untouched = a;
  ThreadPool one(1), four(4);
  fill_moving_depth(clip.frames, clip.cameras, masks, {}, one, monitor_, a);
  fill_moving_depth(clip.frames, clip.cameras, masks, {}, four, monitor_, b);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].depth, b[i].depth);
  struct Stop : Monitor {
    bool progress(std::string_view, long done, long) override { return done < 8; }
  } stop;
  EXPECT_THROW(fill_moving_depth(clip.frames, clip.cameras, masks, {}, one, stop, untouched), Error);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(untouched[i].depth, forget_moving(clip.truth, masks)[i].depth);
}

TEST_F(MovingDepthTest, WhatDoesNotFitTogetherIsRefused) {
  const OrbitingClip clip = ball(0, 1, 2);
  std::vector<ValidityMask> masks = exact_masks(clip, 0);
  std::vector<FrameGeometry> geometry = clip.truth;
  masks[1] = ValidityMask(3, 3);
  EXPECT_THROW(fill(clip, masks, geometry), std::invalid_argument);
  masks.pop_back();
  EXPECT_THROW(fill(clip, masks, geometry), std::invalid_argument);
  EXPECT_THROW((MovingDepthOptions{.lean = -1}.check()), std::invalid_argument);
  EXPECT_THROW((MovingDepthOptions{.confidence = 0.5}.check()), std::invalid_argument);
}

}  // namespace
}  // namespace uwv::testing
