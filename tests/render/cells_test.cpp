// SPDX-License-Identifier: Apache-2.0
// Clouds whose points stand for cells of pixels, against the same clouds with all their points.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/matchers.h"
#include "uwv/eval/image_metrics.h"
#include "uwv/eval/stock_scenes.h"
#include "uwv/geometry/decimation.h"
#include "uwv/render/occlusion.h"

namespace uwv::testing {
namespace {

/// A thinned frame as a source of the renderer.
struct Thinned {
  Thinned(const SyntheticFrame& frame, const Camera& at, const Camera& target, double max_error, ThreadPool& pool)
      : camera(at), colour(frame.colour), depth(frame.depth) {
    const DecimatedDepth cells_of_frame =
        decimate_depth(depth, camera, std::span(&target, 1), {.max_error = max_error}, pool);
    kept = cells_of_frame.kept;
    cells = cells_of_frame.cell;
    limited_slopes_from_depth(depth, camera.intrinsics, {}, pool, slopes);
    for (std::size_t i = 0; i < cells.pixels().size(); ++i)
      if (cells.pixels()[i] > 1)
        depth.pixels()[i] = cells_of_frame.depth.pixels()[i], slopes.pixels()[i] = cells_of_frame.slopes.pixels()[i];
  }
  SourceFrame frame() const {
    SourceFrame source;
    source.camera = camera;
    source.colour = &colour;
    source.depth = &depth;
    source.slopes = &slopes;
    source.valid = &kept;
    source.cells = &cells;
    return source;
  }
  Camera camera;
  ImageRgb colour;
  DepthMap depth;
  SlopeMap slopes;
  ValidityMask kept;
  Image<std::uint8_t> cells;
};

class Cells : public ::testing::Test {
 protected:
  static SourceFrame full(const SyntheticFrame& frame, const Camera& camera) {
    SourceFrame source;
    source.camera = camera;
    source.colour = &frame.colour;
    source.depth = &frame.depth;
    return source;
  }
  RenderedFrame draw(const SourceFrame& source, const Camera& target, OcclusionOptions options = {}) {
    RenderedFrame out;
    OcclusionRenderer(*rasterizer_, pool_, options).render(source, target, out);
    return out;
  }
  ThreadPool pool_{2};
  std::unique_ptr<Rasterizer> rasterizer_ = make_cpu_rasterizer(pool_);
};

TEST_F(Cells, EverySceneLooksAsWithAllItsPoints) {
  for (const StockScene& stock : stock_scenes({.size = {240, 136}})) {
    const SyntheticFrame frame = render(stock.scene, stock.source, 0, pool_, 2);
    const Camera target = orbit_camera(stock.source, stock.subject_in_world, 12 * M_PI / 180);
    const Thinned thinned(frame, stock.source, target, 0.25, pool_);
    const RenderedFrame all = draw(full(frame, stock.source), target), few = draw(thinned.frame(), target);
    EXPECT_NEAR(valid_share(few.valid), valid_share(all.valid), 0.02) << stock.name;
    ValidityMask both = all.valid;
    intersect(both, few.valid);
    EXPECT_GT(psnr(MetricImage(few.colour), MetricImage(all.colour), &both), 30) << stock.name;
    std::size_t elsewhere = 0;
    for (std::size_t i = 0; i < both.pixels().size(); ++i)
      elsewhere += both.pixels()[i] != 0 && std::abs(few.depth.pixels()[i] / all.depth.pixels()[i] - 1) > 0.1F;
    EXPECT_LT(elsewhere, both.count() / 100) << stock.name << ": another surface is seen";
  }
}

TEST_F(Cells, AWallOfFewPointsIsClosedAndExact) {
  const StockScene wall = textured_plane({.size = {320, 192}});
  const SyntheticFrame frame = render(wall.scene, wall.source, 0, pool_, 1);
  for (const double degrees : {0.0, 10.0, 30.0}) {
    const Camera target = orbit_camera(wall.source, wall.subject_in_world, degrees * M_PI / 180);
    const Thinned thinned(frame, wall.source, target, 0.1, pool_);
    EXPECT_LT(thinned.kept.count(), frame.depth.size().pixels() / 100) << degrees;
    const RenderedFrame all = draw(full(frame, wall.source), target), few = draw(thinned.frame(), target);
    EXPECT_GE(few.valid.count() + all.valid.count() / 1000, all.valid.count()) << degrees;
    ValidityMask both = all.valid;
    intersect(both, few.valid);
    float worst = 0;
    for (std::size_t i = 0; i < both.pixels().size(); ++i)
      if (both.pixels()[i] != 0) worst = std::max(worst, std::abs(few.depth.pixels()[i] / all.depth.pixels()[i] - 1));
    EXPECT_LT(worst, 1e-3F) << degrees;
  }
}

TEST_F(Cells, CellsOfOnePixelAreOrdinaryPoints) {
  const StockScene room = boxes_room({.size = {160, 96}});
  const SyntheticFrame frame = render(room.scene, room.source, 0, pool_, 1);
  const Camera target = orbit_camera(room.source, room.subject_in_world, 0.2);
  SlopeMap slopes;
  limited_slopes_from_depth(frame.depth, room.source.intrinsics, {}, pool_, slopes);
  const ValidityMask all(frame.depth.size(), 1);
  const Image<std::uint8_t> ones(frame.depth.size(), 1);
  SourceFrame plain = full(frame, room.source);
  plain.slopes = &slopes, plain.valid = &all;
  SourceFrame celled = plain;
  celled.cells = &ones;
  for (const Kernel kernel : {Kernel::nearest, Kernel::resample})
    for (const Visibility visibility : {Visibility::none, Visibility::ztest, Visibility::reproject}) {
      OcclusionOptions options;
      options.kernel = kernel;
      options.visibility = visibility;
      const RenderedFrame a = draw(plain, target, options), b = draw(celled, target, options);
      EXPECT_EQ(a.valid, b.valid);
      EXPECT_EQ(a.colour, b.colour);
      EXPECT_EQ(a.depth, b.depth);
    }
}

TEST_F(Cells, ThreadsDoNotChangeAByte) {
  const StockScene room = boxes_room({.size = {160, 96}});
  const SyntheticFrame frame = render(room.scene, room.source, 0, pool_, 1);
  const Camera target = orbit_camera(room.source, room.subject_in_world, 0.2);
  const Thinned thinned(frame, room.source, target, 0.5, pool_);
  const auto with = [&](int threads) {
    ThreadPool pool(threads);
    const auto rasterizer = make_cpu_rasterizer(pool);
    RenderedFrame out;
    OcclusionRenderer(*rasterizer, pool, {}).render(thinned.frame(), target, out);
    return out;
  };
  const RenderedFrame a = with(1), b = with(3);
  EXPECT_EQ(a.colour, b.colour);
  EXPECT_EQ(a.valid, b.valid);
}

TEST_F(Cells, MisuseIsRefused) {
  const StockScene room = boxes_room({.size = {32, 32}});
  const SyntheticFrame frame = render(room.scene, room.source, 0, pool_, 1);
  const Image<std::uint8_t> ones(frame.depth.size(), 1), small(3, 3);
  SourceFrame source = full(frame, room.source);
  source.cells = &ones;
  EXPECT_THROW(draw(source, room.source), std::invalid_argument) << "without mask and slopes";
  const SlopeMap slopes(frame.depth.size());
  const ValidityMask all(frame.depth.size(), 1);
  source.slopes = &slopes, source.valid = &all;
  EXPECT_NO_THROW(draw(source, room.source));
  OcclusionOptions dots;
  dots.kernel = Kernel::bilinear;
  EXPECT_THROW(draw(source, room.source, dots), std::invalid_argument);
  source.cells = &small;
  EXPECT_THROW(draw(source, room.source), std::invalid_argument);
}

}  // namespace
}  // namespace uwv::testing
