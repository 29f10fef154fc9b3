// SPDX-License-Identifier: Apache-2.0
#include "uwv/render/other_views.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/matchers.h"
#include "uwv/eval/image_metrics.h"
#include "uwv/eval/stock_scenes.h"

namespace uwv::testing {
namespace {

constexpr double degree = M_PI / 180;

OcclusionOptions occlusion() {
  OcclusionOptions options;
  options.accumulation = Accumulation::none;
  return options;
}

OtherView view_of(const SyntheticFrame& frame, const Camera& camera, long index) {
  return {index, camera, frame.colour, frame.depth, ValidityMask(frame.depth.size(), 1)};
}

/// A room, filmed from 0, seen from 20 degrees to the right, and filmed from further right as well.
class OtherViewsRoom : public ::testing::Test {
 protected:
  OtherViewsRoom() : room_(boxes_room({.size = {240, 136}})) {
    own_ = shoot(0);
    target_ = at(20);
    render_own();
  }
  Camera at(double degrees) const { return orbit_camera(room_.source, room_.subject_in_world, degrees * degree); }
  SyntheticFrame shoot(double degrees) { return uwv::render(room_.scene, at(degrees), 0, pool_, 2); }
  SourceFrame own() const {
    SourceFrame source;
    source.camera = at(0);
    source.colour = &own_.colour;
    source.depth = &own_.depth;
    return source;
  }
  void render_own() { OcclusionRenderer(*rasterizer_, pool_, occlusion()).render(own(), target_, frame_); }
  OtherViews views(const OtherViewsOptions& options = {}) { return {*rasterizer_, pool_, occlusion(), options}; }

  ThreadPool pool_{2};
  std::unique_ptr<Rasterizer> rasterizer_ = make_cpu_rasterizer(pool_);
  StockScene room_;
  SyntheticFrame own_;
  Camera target_;
  RenderedFrame frame_;
};

TEST_F(OtherViewsRoom, HolesGetTheRightColoursAndDepths) {
  const RenderedFrame before = frame_;
  OtherViews others = views();
  for (const double degrees : {35.0, 50.0}) others.add(view_of(shoot(degrees), at(degrees), 1 + others.size()));
  const FillReport report = others.fill(own(), target_, frame_);
  EXPECT_GT(report.open, before.valid.size().pixels() / 20) << "the case leaves something to be filled";
  EXPECT_GT(report.filled, report.open * 7 / 10);
  EXPECT_EQ(frame_.valid.count(), before.valid.count() + report.filled);

  const SyntheticFrame truth = shoot(20);
  ValidityMask added = frame_.valid;
  std::size_t wrong_depth = 0;
  for (std::size_t i = 0; i < added.pixels().size(); ++i) {
    if (before.valid.pixels()[i] != 0) {
      added.pixels()[i] = 0;
      ASSERT_EQ(frame_.colour.pixels()[i], before.colour.pixels()[i]) << "the frame's own pixels stay";
    } else if (added.pixels()[i] != 0) {
      wrong_depth += std::abs(frame_.depth.pixels()[i] / truth.depth.pixels()[i] - 1) > 0.02;
    }
  }
  EXPECT_LT(wrong_depth, report.filled / 33);
  EXPECT_GT(psnr(MetricImage(frame_.colour), MetricImage(truth.colour), &added), 25);
  EXPECT_GT(valid_share(frame_.valid), 0.9);
}

TEST_F(OtherViewsRoom, AnotherExposureIsMatched) {
  SyntheticFrame dark = shoot(35);
  for (Rgb8& p : dark.colour.pixels())
    p = {static_cast<std::uint8_t>(p.r * 0.85), static_cast<std::uint8_t>(p.g * 0.85),
         static_cast<std::uint8_t>(p.b * 0.9)};
  const RenderedFrame before = frame_;
  const SyntheticFrame truth = shoot(20);
  const auto error = [&](float max_gain) {
    RenderedFrame frame = before;
    OtherViews others = views({.max_gain = max_gain});
    others.add(view_of(dark, at(35), 1));
    others.fill(own(), target_, frame);
    ValidityMask added = frame.valid;
    for (std::size_t i = 0; i < added.pixels().size(); ++i) added.pixels()[i] &= 1U ^ before.valid.pixels()[i];
    return psnr(MetricImage(frame.colour), MetricImage(truth.colour), &added);
  };
  EXPECT_GT(error(1.25F), error(1) + 2);
}

TEST_F(OtherViewsRoom, AViewThatContradictsEverywhereIsLeftOut) {
  SyntheticFrame nearer = shoot(35);
  for (float& z : nearer.depth.pixels()) z *= 0.7F;
  OtherViews others = views();
  others.add(view_of(nearer, at(35), 1));
  const RenderedFrame before = frame_;
  const FillReport report = others.fill(own(), target_, frame_);
  EXPECT_EQ(report.refused, 1);
  EXPECT_EQ(report.filled, 0U);
  EXPECT_EQ(frame_.valid, before.valid);
}

TEST_F(OtherViewsRoom, OnlyUsablePointsOfOtherFramesJoin) {
  const RenderedFrame before = frame_;
  OtherViews others = views();
  OtherView moving = view_of(shoot(35), at(35), 1);
  moving.usable.fill(0);
  others.add(std::move(moving));
  others.add(view_of(shoot(35), at(35), 0));  // the frame itself
  const FillReport report = others.fill(own(), target_, frame_);
  EXPECT_EQ(report.views, 0);
  EXPECT_EQ(frame_.valid, before.valid);
}

TEST_F(OtherViewsRoom, OneViewIsEnoughWhereOneIsAllowed) {
  OtherViews others = views({.max_views = 1});
  for (const double degrees : {5.0, 35.0, 50.0}) others.add(view_of(shoot(degrees), at(degrees), 1 + others.size()));
  RenderedFrame one = frame_;
  const FillReport limited = others.fill(own(), target_, one);
  EXPECT_EQ(limited.views, 1);
  EXPECT_GT(limited.filled, limited.open / 3) << "the most useful comes first, not the nearest";
}

TEST_F(OtherViewsRoom, ThreadsDoNotChangeAByte) {
  const auto filled_with = [&](int threads) {
    ThreadPool pool(threads);
    const auto rasterizer = make_cpu_rasterizer(pool);
    OtherViews others(*rasterizer, pool, occlusion(), {});
    for (const double degrees : {35.0, 50.0}) others.add(view_of(shoot(degrees), at(degrees), 1 + others.size()));
    RenderedFrame frame = frame_;
    others.fill(own(), target_, frame);
    return frame;
  };
  const RenderedFrame a = filled_with(1), b = filled_with(3);
  EXPECT_EQ(a.colour, b.colour);
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_EQ(a.valid, b.valid);
}

/// A picture of one colour with depth `far`, and `near` inside the middle rectangle.
struct Step {
  Camera camera;
  ImageRgb colour;
  DepthMap depth;
  Step(const Camera& at, float near, float far, Rgb8 tone) : camera(at), colour(at.size, tone), depth(at.size, far) {
    for (int y = 16; y < 48; ++y)
      for (int x = 32; x < 64; ++x) depth(x, y) = near;
  }
  SourceFrame frame() const {
    SourceFrame source;
    source.camera = camera;
    source.colour = &colour;
    source.depth = &depth;
    return source;
  }
};

class OtherViewsStep : public ::testing::Test {
 protected:
  static Camera camera(double x = 0, double unit = 1) {
    Camera made{Intrinsics::from_fov_x(1.0, {96, 64}), {}, {96, 64}};
    made.world_from_cam.translation.x() = x * unit;
    return made;
  }
  /// The own frame as it is, with the middle taken out as if nothing of it had been drawn.
  static RenderedFrame holed(const Step& own) {
    RenderedFrame frame{own.colour, own.depth, ValidityMask(own.camera.size, 1)};
    for (int y = 20; y < 44; ++y)
      for (int x = 36; x < 60; ++x) frame.valid(x, y) = 0, frame.depth(x, y) = 0, frame.colour(x, y) = {};
    return frame;
  }
  FillReport fill(const Step& own, const Step& other, RenderedFrame& frame) {
    OtherViews others(*rasterizer_, pool_, occlusion(), {});
    others.add({7, other.camera, other.colour, other.depth, ValidityMask(other.camera.size, 1)});
    return others.fill(own.frame(), own.camera, frame);
  }
  ThreadPool pool_{2};
  std::unique_ptr<Rasterizer> rasterizer_ = make_cpu_rasterizer(pool_);
};

TEST_F(OtherViewsStep, NothingShinesThroughWhatTheFrameKnows) {
  const Step own(camera(), 2, 4, {200, 0, 0}), wall(camera(0.05), 4, 4, {0, 200, 0});
  RenderedFrame frame = holed(own);
  const FillReport report = fill(own, wall, frame);
  EXPECT_EQ(report.filled, 0U) << "the square is there, drawn or not";
  EXPECT_EQ(report.hidden, report.open);
}

TEST_F(OtherViewsStep, WhatTheFrameSeesThroughIsNotThere) {
  const Step own(camera(), 4, 4, {200, 0, 0}), ghost(camera(0.05), 2, 4, {0, 200, 0});
  RenderedFrame frame = holed(own);
  const FillReport report = fill(own, ghost, frame);
  EXPECT_GT(report.contradicted, report.open / 2);
  for (int y = 26; y < 38; ++y)
    for (int x = 42; x < 52; ++x) EXPECT_EQ(frame.valid(x, y), 0) << x << " " << y;
}

TEST_F(OtherViewsStep, TheSameSurfaceFills) {
  const Step own(camera(), 2, 4, {100, 100, 100}), same(camera(0.02), 2, 4, {100, 100, 100});
  RenderedFrame frame = holed(own);
  const FillReport report = fill(own, same, frame);
  EXPECT_EQ(report.filled, report.open);
  EXPECT_EQ(frame.colour(48, 32), (Rgb8{100, 100, 100}));
  EXPECT_NEAR(frame.depth(48, 32), 2, 1e-4);
}

TEST_F(OtherViewsStep, TheUnitOfLengthDoesNotMatter) {
  std::size_t filled = 0;
  for (const double unit : {1.0, 1e-6, 1e8}) {
    const auto near = static_cast<float>(2 * unit), far = static_cast<float>(4 * unit);
    const Step own(camera(0, unit), near, far, {90, 90, 90}), same(camera(0.02, unit), near, far, {90, 90, 90});
    RenderedFrame frame = holed(own);
    const FillReport report = fill(own, same, frame);
    if (unit == 1) filled = report.filled;
    EXPECT_EQ(report.filled, filled) << unit;
  }
}

TEST_F(OtherViewsStep, ExtremesAreAnswered) {
  const Step own(camera(), 2, 4, {1, 2, 3});
  OtherViews none(*rasterizer_, pool_, occlusion(), {});
  RenderedFrame frame = holed(own);
  const RenderedFrame before = frame;
  EXPECT_EQ(none.fill(own.frame(), own.camera, frame).filled, 0U);
  EXPECT_EQ(frame.valid, before.valid);

  Step nothing(camera(0.1), 0, 0, {9, 9, 9});  // no depth at all
  EXPECT_EQ(fill(own, nothing, frame).views, 0);
  nothing.depth.fill(std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(fill(own, nothing, frame).filled, 0U);
  nothing.depth.fill(std::numeric_limits<float>::infinity());
  EXPECT_EQ(fill(own, nothing, frame).filled, 0U);
  Step behind(camera(), 2, 4, {9, 9, 9});
  behind.camera.world_from_cam.translation.z() = -100;  // its points lie in front of the target, its camera far behind
  behind.depth.fill(50);
  EXPECT_EQ(fill(own, behind, frame).filled, 0U) << "all of it lies behind the target camera";

  RenderedFrame full{own.colour, own.depth, ValidityMask(own.camera.size, 1)};
  EXPECT_EQ(fill(own, own, full).views, 0) << "nothing is open";

  const Camera pixel{Intrinsics::from_fov_x(1.0, {1, 1}), {}, {1, 1}};
  const ImageRgb colour(1, 1, Rgb8{5, 6, 7});
  const DepthMap depth(1, 1, 3.0F);
  SourceFrame dot;
  dot.camera = pixel, dot.colour = &colour, dot.depth = &depth;
  OtherViews dots(*rasterizer_, pool_, occlusion(), {});
  dots.add({1, pixel, colour, depth, ValidityMask(Size{1, 1}, 1)});
  RenderedFrame empty{ImageRgb(1, 1), DepthMap(1, 1), ValidityMask(1, 1)};
  EXPECT_LE(dots.fill(dot, pixel, empty).filled, 1U);
}

TEST_F(OtherViewsStep, MisuseIsRefused) {
  EXPECT_THROW(OtherViews(*rasterizer_, pool_, occlusion(), {.max_views = 0}), std::invalid_argument);
  EXPECT_THROW(OtherViews(*rasterizer_, pool_, occlusion(), {.tolerance = 0.6F}), std::invalid_argument);
  EXPECT_THROW(OtherViews(*rasterizer_, pool_, occlusion(), {.max_gain = 0.5F}), std::invalid_argument);
  OtherViews others(*rasterizer_, pool_, occlusion(), {});
  const Step own(camera(), 2, 4, {1, 2, 3});
  EXPECT_THROW(others.add({1, own.camera, ImageRgb(3, 3), own.depth, ValidityMask(own.camera.size, 1)}),
               std::invalid_argument);
  RenderedFrame small{ImageRgb(3, 3), DepthMap(3, 3), ValidityMask(3, 3)};
  EXPECT_THROW(others.fill(own.frame(), own.camera, small), std::invalid_argument);
}

}  // namespace
}  // namespace uwv::testing
