// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/background_from_views.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "geometry/moving/orbiting_clip.h"
#include "uwv/core/depth.h"

namespace uwv::testing {
namespace {

constexpr int ball_index = 0;

/// A ball passing a box and a wall before an orbiting camera, and the same without the ball.
struct Passing {
  OrbitingClip with, without;
  std::vector<ForegroundMask> ball;
};

Passing passing_ball(int frames, double degrees, double unit, ThreadPool& pool) {
  StockOptions options;
  options.size = {320, 184};
  options.unit = unit;
  StockScene scene = moving_ball(options);
  Passing clip;
  clip.with = orbiting_clip(scene, frames, degrees, 1.0, pool);
  scene.scene.objects.erase(scene.scene.objects.begin() + ball_index);
  clip.without = orbiting_clip(scene, frames, degrees, 1.0, pool);
  for (std::size_t i = 0; i < clip.with.object.size(); ++i) {
    ForegroundMask& mask = clip.ball.emplace_back(clip.with.object[i].size());
    for (std::size_t p = 0; p < mask.pixels().size(); ++p) {
      mask.pixels()[p] = clip.with.object[i].pixels()[p] == ball_index ? 1 : 0;
      if (mask.pixels()[p] != 0) clip.with.truth[i].depth.pixels()[p] = 0;
    }
  }
  return clip;
}

struct Score {
  double psnr = 0, abs_rel = 0, share = 0;
};

/// Of the pixels that came from `origin`, over all frames.
Score score(const Passing& clip, const ViewsBackground& got, BackgroundOrigin origin) {
  double squared = 0, relative = 0, count = 0, all = 0;
  for (std::size_t i = 0; i < got.frames.size(); ++i)
    for (std::size_t p = 0; p < got.frames[i].pixels().size(); ++p) {
      all += 1;
      if (got.origin[i].pixels()[p] != static_cast<std::uint8_t>(origin)) continue;
      const Rgb8 a = got.frames[i].pixels()[p], b = clip.without.frames[i].pixels()[p];
      squared += (std::pow(a.r - b.r, 2) + std::pow(a.g - b.g, 2) + std::pow(a.b - b.b, 2)) / 3;
      const double truth = clip.without.truth[i].depth.pixels()[p];
      relative += std::abs(got.depth[i].pixels()[p] - truth) / truth;
      count += 1;
    }
  if (!(count > 0)) return {};
  return {10 * std::log10(255.0 * 255.0 * count / std::max(1e-9, squared)), relative / count, count / all};
}

class BackgroundFromViews : public ::testing::Test {
 protected:
  ViewsBackground complete(const Passing& clip, const ViewsOptions& options = {}) {
    return background_from_views(clip.with.frames, clip.with.cameras, clip.with.truth, clip.ball, options, pool_,
                                 monitor_);
  }
  ThreadPool pool_{2};
  Monitor monitor_;
};

TEST_F(BackgroundFromViews, ShowsWhatTheBallHides) {
  const Passing clip = passing_ball(21, 8, 1, pool_);
  const ViewsBackground got = complete(clip);
  const Score own = score(clip, got, BackgroundOrigin::own), seen = score(clip, got, BackgroundOrigin::seen);
  EXPECT_GT(seen.share, 0.04);
  EXPECT_LT(got.share_invented, 0.002) << got.brief();
  EXPECT_GT(seen.psnr, 31) << got.brief();  // measured: 32.4
  EXPECT_LT(seen.abs_rel, 0.004);           // measured: 0.0015
  EXPECT_GT(own.psnr, 60);
  EXPECT_LT(own.abs_rel, 1e-6);
  EXPECT_NEAR(got.share_seen, seen.share, 1e-12);
}

TEST_F(BackgroundFromViews, IsRobustToDepthNoise) {
  Passing clip = passing_ball(21, 8, 1, pool_);
  for (std::size_t i = 0; i < clip.with.truth.size(); ++i)
    for (std::size_t p = 0; p < clip.with.truth[i].depth.pixels().size(); ++p)
      clip.with.truth[i].depth.pixels()[p] *=
          1 + 0.02F * std::sin(static_cast<float>(p * 12.9898 + static_cast<double>(i) * 78.233));
  const Score seen = score(clip, complete(clip), BackgroundOrigin::seen);
  EXPECT_GT(seen.psnr, 30);        // measured: 31.7
  EXPECT_LT(seen.abs_rel, 0.012);  // measured: 0.009, of a noise of 0.014
}

TEST_F(BackgroundFromViews, MatchesExposure) {
  Passing clip = passing_ball(21, 8, 1, pool_);
  for (std::size_t i = 0; i < clip.with.frames.size(); ++i)
    for (auto* frames : {&clip.with.frames, &clip.without.frames})
      for (Rgb8& c : (*frames)[i].pixels()) {
        const double gain = 0.6 + 0.015 * static_cast<double>(i);
        const auto scaled = [&](std::uint8_t v) { return static_cast<std::uint8_t>(v * gain + 0.5); };
        c = {scaled(c.r), scaled(c.g), scaled(c.b)};
      }
  const double matched = score(clip, complete(clip), BackgroundOrigin::seen).psnr;
  const double unmatched = score(clip, complete(clip, {.match_exposure = false}), BackgroundOrigin::seen).psnr;
  EXPECT_GT(matched, 27);
  EXPECT_GT(matched, unmatched + 3);
}

TEST_F(BackgroundFromViews, TheUnitOfLengthDoesNotMatter) {
  const ViewsBackground plain = complete(passing_ball(7, 8, 1, pool_));
  for (const double unit : {1e-6, 1e9}) {
    const Passing clip = passing_ball(7, 8, unit, pool_);
    const ViewsBackground got = complete(clip);
    EXPECT_NEAR(got.share_seen, plain.share_seen, 0.001);
    const Score seen = score(clip, got, BackgroundOrigin::seen);
    EXPECT_LT(seen.abs_rel, 0.01) << "unit " << unit;
    EXPECT_GT(seen.psnr, 25) << "unit " << unit;
  }
}

TEST_F(BackgroundFromViews, WhatNobodySawIsInventedOnceAndItsDepthContinued) {
  // The mask stands still in the world, and so does the camera: no other frame ever sees behind it.
  StockOptions options;
  options.size = {160, 96};
  OrbitingClip clip = orbiting_clip(sphere_floor_wall(options), 4, 0, 0, pool_);
  std::vector<ForegroundMask> masks(4, ForegroundMask(options.size));
  for (ForegroundMask& mask : masks)
    for (int y = 80; y < 90; ++y)
      for (int x = 20; x < 50; ++x) mask(x, y) = 1;
  const std::vector<FrameGeometry> truth = clip.truth;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t p = 0; p < masks[i].pixels().size(); ++p)
      if (masks[i].pixels()[p] != 0) clip.truth[i].depth.pixels()[p] = 0;
  const ViewsBackground got =
      background_from_views(clip.frames, clip.cameras, clip.truth, masks, {.margin_px = 1}, pool_, monitor_);
  EXPECT_EQ(got.share_seen, 0);
  EXPECT_GT(got.share_invented, 0.01);
  ASSERT_FALSE(got.notes.empty());
  for (int y = 80; y < 90; ++y)
    for (int x = 20; x < 50; ++x) {
      EXPECT_EQ(got.origin[2](x, y), static_cast<std::uint8_t>(BackgroundOrigin::invented));
      // The floor is a plane: harmonic inverse depth continues it.
      EXPECT_NEAR(got.depth[2](x, y) / truth[2].depth(x, y), 1, 0.01) << x << ' ' << y;
      for (std::size_t i = 1; i < 4; ++i) EXPECT_EQ(got.frames[i](x, y), got.frames[0](x, y));
    }
}

TEST_F(BackgroundFromViews, UnusableDepthIsUnknownAndNothingIsInventedFromNothing) {
  Passing clip = passing_ball(5, 8, 1, pool_);
  for (FrameGeometry& frame : clip.with.truth)
    for (std::size_t p = 0; p < frame.depth.pixels().size(); ++p)
      frame.depth.pixels()[p] = p % 2 == 0 ? std::numeric_limits<float>::quiet_NaN() : -1.0F;
  const ViewsBackground got = complete(clip);
  EXPECT_EQ(got.share_seen, 0);
  for (const DepthMap& depth : got.depth)
    for (const float z : depth.pixels()) ASSERT_EQ(z, 0);
  EXPECT_EQ(got.notes.size(), 2U);
}

TEST_F(BackgroundFromViews, WholePicturesSinglePixelsAndSingleFramesAreAnswered) {
  const Passing clip = passing_ball(3, 8, 1, pool_);
  const std::vector<ForegroundMask> all(3, ForegroundMask(clip.ball[0].size(), std::uint8_t{1}));
  const ViewsBackground blind =
      background_from_views(clip.with.frames, clip.with.cameras, clip.with.truth, all, {}, pool_, monitor_);
  EXPECT_EQ(blind.share_invented, 1);
  const std::vector<ForegroundMask> none(3, ForegroundMask(clip.ball[0].size()));
  const ViewsBackground same =
      background_from_views(clip.with.frames, clip.with.cameras, clip.with.truth, none, {}, pool_, monitor_);
  EXPECT_EQ(same.frames, clip.with.frames);
  EXPECT_TRUE(same.notes.empty());
  const ViewsBackground alone =
      background_from_views(std::span(clip.with.frames).first(1), std::span(clip.with.cameras).first(1),
                            std::span(clip.with.truth).first(1), std::span(clip.ball).first(1), {}, pool_, monitor_);
  EXPECT_EQ(alone.share_seen, 0);
  Camera dot;
  dot.size = {1, 1};
  dot.intrinsics = Intrinsics::from_fov_x(1, dot.size);
  for (const std::uint8_t moves : {std::uint8_t{0}, std::uint8_t{1}}) {
    const ViewsBackground got =
        background_from_views(std::vector<ImageRgb>(2, ImageRgb(1, 1)), std::vector<Camera>(2, dot),
                              std::vector<FrameGeometry>(2, {DepthMap(1, 1, 2.0F), ConfidenceMap(1, 1, 1.0F)}),
                              std::vector<ForegroundMask>(2, ForegroundMask(1, 1, moves)), {}, pool_, monitor_);
    EXPECT_EQ(got.depth[0](0, 0), moves != 0 ? 0.0F : 2.0F);
  }
}

TEST_F(BackgroundFromViews, ThreadsDoNotChangeTheResult) {
  const Passing clip = passing_ball(9, 8, 1, pool_);
  ThreadPool one(1), four(4);
  const auto with = [&](ThreadPool& pool) {
    return background_from_views(clip.with.frames, clip.with.cameras, clip.with.truth, clip.ball, {}, pool, monitor_);
  };
  const ViewsBackground a = with(one), b = with(four);
  EXPECT_EQ(a.frames, b.frames);
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_EQ(a.origin, b.origin);
}

TEST_F(BackgroundFromViews, StopsWhenAsked) {
  const Passing clip = passing_ball(3, 8, 1, pool_);
  for (const char* stage : {"background: sightings", "background: inventing"}) {
    struct Stop : Monitor {
      explicit Stop(std::string_view stage) : stage_(stage) {}
      bool progress(std::string_view stage, long, long) override { return stage != stage_; }
      std::string_view stage_;
    } stop(stage);
    EXPECT_THROW(
        background_from_views(clip.with.frames, clip.with.cameras, clip.with.truth, clip.ball, {}, pool_, stop), Error);
  }
}

TEST_F(BackgroundFromViews, WhatDoesNotFitTogetherIsRefused) {
  Passing clip = passing_ball(2, 8, 1, pool_);
  EXPECT_THROW(complete(clip, {.views = 0}), std::invalid_argument);
  EXPECT_THROW(complete(clip, {.depth_tolerance = std::nan("")}), std::invalid_argument);
  clip.ball[1] = ForegroundMask(3, 3);
  EXPECT_THROW(complete(clip), std::invalid_argument);
  clip.ball.pop_back();
  EXPECT_THROW(complete(clip), std::invalid_argument);
}

}  // namespace
}  // namespace uwv::testing
