// SPDX-License-Identifier: Apache-2.0
// What the renderer promises about its passes: skipping changes nothing, masks combine as asked, reports tell the
// truth.
#include "uwv/render/occlusion.h"

#include <gtest/gtest.h>

#include <numbers>

#include "uwv/eval/stock_scenes.h"

namespace uwv::testing {
namespace {

/// A small scene with its source frame.
class OcclusionTest : public ::testing::Test {
 protected:
  OcclusionTest() : scene_(boxes_room({.size = {208, 120}})), frame_(render(scene_.scene, scene_.source, 0, pool_)) {}

  SourceFrame source(long index = 0) const {
    SourceFrame out;
    out.index = index;
    out.camera = scene_.source;
    out.colour = &frame_.colour;
    out.depth = &frame_.depth;
    return out;
  }
  Camera orbit(double degrees) const {
    return orbit_camera(scene_.source, scene_.subject_in_world, degrees * std::numbers::pi / 180);
  }
  /// Turned in place and zoomed.
  Camera turned(double degrees, double zoom) const {
    Camera camera = scene_.source;
    camera.world_from_cam.rotation *=
        Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Eigen::Vector3d(0.3, 1, 0.2).normalized())
            .toRotationMatrix();
    camera.intrinsics.fx *= zoom;
    camera.intrinsics.fy *= zoom;
    return camera;
  }

  ThreadPool pool_{2};
  StockScene scene_;
  SyntheticFrame frame_;
  std::unique_ptr<Rasterizer> rasterizer_ = make_cpu_rasterizer(pool_);
};

void expect_equal(const RenderedFrame& a, const RenderedFrame& b) {
  EXPECT_EQ(a.colour, b.colour);
  EXPECT_EQ(a.valid, b.valid);
  ASSERT_EQ(a.depth.size(), b.depth.size());
  std::size_t differ = 0;
  for (std::size_t i = 0; i < a.depth.size().pixels(); ++i)
    differ += !(std::fabs(a.depth.data()[i] - b.depth.data()[i]) <= 1e-5F * b.depth.data()[i]);
  EXPECT_EQ(differ, 0U) << "depths";
}

TEST_F(OcclusionTest, SkippingPassesChangesNoPixel) {
  // Standing still, orbiting, turning, zooming out and coming back to the start.
  const std::vector<Camera> path{orbit(0),       orbit(0),       orbit(1),       orbit(4), orbit(4),
                                 turned(0, 0.9), turned(1, 0.8), turned(2, 0.8), orbit(8), orbit(20),
                                 orbit(20),      orbit(0),       turned(3, 0.75)};
  for (const Kernel kernel : {Kernel::nearest, Kernel::resample})
    for (const Visibility visibility : {Visibility::none, Visibility::ztest, Visibility::reproject})
      for (const Accumulation accumulation :
           {Accumulation::product, Accumulation::product_in_view, Accumulation::none}) {
        SCOPED_TRACE(fmt::format("{} {} {}", to_string(kernel), to_string(visibility), to_string(accumulation)));
        OcclusionOptions options;
        options.kernel = kernel;
        options.visibility = visibility;
        options.accumulation = accumulation;
        OcclusionRenderer skipping(*rasterizer_, pool_, options);
        options.skip_unneeded = false;
        OcclusionRenderer full(*rasterizer_, pool_, options);
        int passes = 0, all_passes = 0, skips = 0;
        for (std::size_t i = 0; i < path.size(); ++i) {
          SCOPED_TRACE("frame " + std::to_string(i));
          RenderedFrame a, b;
          const FrameReport report = skipping.render(source(), path[i], a);
          const FrameReport whole = full.render(source(), path[i], b);
          expect_equal(a, b);
          passes += report.passes;
          all_passes += whole.passes;
          skips += !report.skipped.empty();
          EXPECT_TRUE(whole.skipped.empty()) << whole.skipped;
        }
        EXPECT_LT(passes, all_passes);
        EXPECT_GE(skips, 4);
      }
}

TEST_F(OcclusionTest, AtTheSourceCameraTheRenderEqualsTheSource) {
  for (const Kernel kernel : {Kernel::nearest, Kernel::resample})
    for (const bool skip : {true, false}) {
      OcclusionOptions options;
      options.kernel = kernel;
      options.skip_unneeded = skip;
      options.reliability.enabled = false;
      OcclusionRenderer renderer(*rasterizer_, pool_, options);
      RenderedFrame out;
      renderer.render(source(), scene_.source, out);
      for (std::size_t i = 0; i < out.valid.size().pixels(); ++i) {
        ASSERT_EQ(out.valid.data()[i] != 0, frame_.depth.data()[i] > 0);
        if (out.valid.data()[i] == 0) continue;
        ASSERT_EQ(out.colour.data()[i], frame_.colour.data()[i]) << i;
        ASSERT_NEAR(out.depth.data()[i], frame_.depth.data()[i], 1e-5 * frame_.depth.data()[i]);
      }
    }
}

TEST_F(OcclusionTest, OnceHiddenStaysHiddenOnlyUnderTheProduct) {
  const auto visible_after_return = [&](Accumulation accumulation) {
    OcclusionOptions options;
    options.accumulation = accumulation;
    OcclusionRenderer renderer(*rasterizer_, pool_, options);
    RenderedFrame out;
    for (const double degrees : {5.0, 25.0, 5.0}) renderer.render(source(), orbit(degrees), out);
    return out.valid.count();
  };
  const std::size_t product = visible_after_return(Accumulation::product);
  const std::size_t in_view = visible_after_return(Accumulation::product_in_view);
  const std::size_t none = visible_after_return(Accumulation::none);
  EXPECT_LT(product, in_view);
  EXPECT_LT(in_view, none);
}

TEST_F(OcclusionTest, ForegroundIsKeptAndReenters) {
  ValidityMask foreground(frame_.depth.size(), 0);
  for (int y = 40; y < 80; ++y)
    for (int x = 80; x < 130; ++x) foreground(x, y) = 1;
  OcclusionOptions options;
  options.accumulation = Accumulation::foreground;
  OcclusionRenderer renderer(*rasterizer_, pool_, options);
  SourceFrame with_foreground = source();
  with_foreground.foreground = &foreground;
  RenderedFrame out;
  FrameMasks masks;
  renderer.render(with_foreground, orbit(20), out, &masks);
  for (std::size_t i = 0; i < foreground.size().pixels(); ++i) ASSERT_GE(masks.visible.data()[i], foreground.data()[i]);
  EXPECT_THROW(renderer.render(source(1), orbit(25), out), std::invalid_argument);
}

TEST_F(OcclusionTest, RestartForgetsThePath) {
  OcclusionRenderer renderer(*rasterizer_, pool_, {});
  RenderedFrame first, after, again;
  renderer.render(source(), orbit(10), first);
  renderer.render(source(), orbit(60), after);
  renderer.restart();
  renderer.render(source(), orbit(10), again);
  expect_equal(again, first);
}

TEST_F(OcclusionTest, AFringeOnlyAddsPixels) {
  for (const Kernel kernel : {Kernel::nearest, Kernel::resample}) {
    OcclusionOptions options;
    options.kernel = kernel;
    OcclusionRenderer plain(*rasterizer_, pool_, options);
    options.fringe = 1;
    OcclusionRenderer fringed(*rasterizer_, pool_, options);
    RenderedFrame without, with;
    FrameMasks masks_without, masks_with;
    plain.render(source(), orbit(30), without, &masks_without);
    fringed.render(source(), orbit(30), with, &masks_with);
    EXPECT_EQ(masks_with.second, masks_without.second);
    EXPECT_EQ(masks_with.visible, masks_without.visible);
    for (std::size_t i = 0; i < without.valid.size().pixels(); ++i) {
      if (without.valid.data()[i] == 0) continue;
      ASSERT_EQ(with.valid.data()[i], 1);
      ASSERT_EQ(with.colour.data()[i], without.colour.data()[i]);
      ASSERT_EQ(with.depth.data()[i], without.depth.data()[i]);
    }
    EXPECT_GT(with.valid.count(), without.valid.count());
    EXPECT_LT(with.valid.count(), without.valid.count() * 11 / 10);
    // A view that stands still is shown again, fringe and all.
    RenderedFrame again;
    EXPECT_EQ(fringed.render(source(), orbit(30), again).passes, 0);
    EXPECT_EQ(again.valid, with.valid);
    EXPECT_EQ(again.colour, with.colour);
  }
}

TEST_F(OcclusionTest, MasksAndReportAgree) {
  OcclusionRenderer renderer(*rasterizer_, pool_, {});
  RenderedFrame out;
  FrameMasks masks;
  const FrameReport report = renderer.render(source(), orbit(30), out, &masks);
  EXPECT_EQ(report.passes, 3);
  EXPECT_GT(report.points, report.drawn);
  EXPECT_EQ(masks.first.size(), out.valid.size());
  for (std::size_t i = 0; i < out.valid.size().pixels(); ++i) ASSERT_GE(masks.first.data()[i], out.valid.data()[i]);
  EXPECT_EQ(masks.second, masks.visible);  // one frame: the product is its only factor
}

TEST_F(OcclusionTest, OptionsOutOfRangeAndMisfitsAreRefused) {
  OcclusionOptions options;
  options.alpha = -0.1;
  EXPECT_THROW(OcclusionRenderer(*rasterizer_, pool_, options), std::invalid_argument);
  options = {};
  options.depth_tolerance = 1.0F;
  EXPECT_THROW(OcclusionRenderer(*rasterizer_, pool_, options), std::invalid_argument);
  OcclusionRenderer renderer(*rasterizer_, pool_, {});
  RenderedFrame out;
  SourceFrame bad = source();
  bad.depth = nullptr;
  EXPECT_THROW(renderer.render(bad, scene_.source, out), std::invalid_argument);
  bad = source();
  const ImageRgb other(3, 3);
  bad.colour = &other;
  EXPECT_THROW(renderer.render(bad, scene_.source, out), std::invalid_argument);
}

TEST(OcclusionNames, RoundTripAndListTheKnownOnes) {
  for (const Kernel k : {Kernel::nearest, Kernel::bilinear, Kernel::resample}) EXPECT_EQ(parse_kernel(to_string(k)), k);
  for (const Visibility v : {Visibility::none, Visibility::ztest, Visibility::reproject})
    EXPECT_EQ(parse_visibility(to_string(v)), v);
  for (const Accumulation a :
       {Accumulation::product, Accumulation::product_in_view, Accumulation::none, Accumulation::foreground})
    EXPECT_EQ(parse_accumulation(to_string(a)), a);
  try {
    parse_kernel("blinear");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::value_invalid);
    EXPECT_NE(std::string(error.what()).find("bilinear"), std::string::npos);
  }
}

}  // namespace
}  // namespace uwv::testing
