// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>

#include "render/surface.h"
#include "support/render_scenes.h"

namespace uwv::testing {
namespace {

TEST(CpuRasterizerTest, DrawsWhatTheReferenceDraws) {
  ThreadPool pool(2);
  const auto rasterizer = make_cpu_rasterizer(pool);
  for (const Scene& scene : all_scenes()) {
    SCOPED_TRACE(scene.name);
    ZBuffer wanted, got;
    naive_zbuffer(scene.grid(), scene.target, scene.footprint, wanted);
    rasterizer->zbuffer(scene.grid(), scene.target, scene.footprint, got);
    expect_same(wanted, got);
    ValidityMask wanted_mask, got_mask;
    naive_coverage(scene.grid(), scene.target, scene.footprint, wanted_mask);
    rasterizer->coverage(scene.grid(), scene.target, scene.footprint, got_mask);
    expect_same(wanted_mask, got_mask);
    for (const ImageRgbF* colour : {&scene.colour, static_cast<const ImageRgbF*>(nullptr)}) {
      SoftSplat wanted_splat, got_splat;
      naive_soft_splat(scene.grid(), colour, scene.target, {}, wanted_splat);
      rasterizer->soft_splat(scene.grid(), colour, scene.target, {}, got_splat);
      expect_same(wanted_splat, got_splat);
    }
  }
}

TEST(CpuRasterizerTest, NarrowingGivesWhatDrawingThePartGives) {
  for (const int threads : {1, 3}) {
    ThreadPool pool(threads);
    const auto rasterizer = make_cpu_rasterizer(pool);
    for (const Scene& scene : all_scenes()) {
      SCOPED_TRACE(scene.name);
      expect_narrows_to_parts(*rasterizer, scene);
    }
  }
}

TEST(CpuRasterizerTest, FillsOnlyEmptyPixels) {
  ThreadPool pool(2);
  const auto rasterizer = make_cpu_rasterizer(pool);
  for (const Scene& scene : all_scenes()) {
    SCOPED_TRACE(scene.name);
    expect_fills_empty_pixels(*rasterizer, scene);
  }
}

TEST(CpuRasterizerTest, NarrowsAnotherRenderersZBuffer) {
  ThreadPool pool(2);
  const auto rasterizer = make_cpu_rasterizer(pool);
  const Scene scene = all_scenes().front();
  ZBuffer whole, wanted;
  rasterizer->zbuffer(scene.grid(), scene.target, scene.footprint, whole);
  whole.reach.clear();
  const ValidityMask half = parts_of(scene)[3];
  PointGrid grid = scene.grid();
  grid.keep = &half;
  rasterizer->zbuffer(grid, scene.target, scene.footprint, wanted);
  EXPECT_GT(rasterizer->narrow(grid, scene.target, scene.footprint, whole), 0U);
  expect_same(wanted, whole);
}

TEST(CpuRasterizerTest, ComesBackAsTheSurfaceDoes) {
  ThreadPool pool(2);
  const auto rasterizer = make_cpu_rasterizer(pool);
  for (const Scene& scene : all_scenes()) {
    SCOPED_TRACE(scene.name);
    ZBuffer zbuffer;
    rasterizer->zbuffer(scene.grid(), scene.target, scene.footprint, zbuffer);
    DepthMap depth;
    SlopeMap slopes;
    detail::surface_geometry(scene.grid(), scene.target, zbuffer, pool, depth, &slopes);
    ValidityMask wanted, got;
    rasterizer->coverage({scene.target, &depth, &slopes, nullptr}, scene.source, scene.footprint, wanted);
    ASSERT_TRUE(rasterizer->come_back(scene.grid(), scene.target, zbuffer, scene.footprint, got));
    expect_same(wanted, got);
  }
}

TEST(CpuRasterizerTest, CoverageIsWhereTheZBufferIsFull) {
  ThreadPool pool(2);
  const auto rasterizer = make_cpu_rasterizer(pool);
  for (const Scene& scene : all_scenes()) {
    SCOPED_TRACE(scene.name);
    ZBuffer zbuffer;
    ValidityMask covered;
    rasterizer->zbuffer(scene.grid(), scene.target, scene.footprint, zbuffer);
    rasterizer->coverage(scene.grid(), scene.target, scene.footprint, covered);
    for (std::size_t i = 0; i < covered.size().pixels(); ++i) {
      ASSERT_EQ(covered.data()[i] != 0, zbuffer.winner.data()[i] != PointCode::none);
      ASSERT_EQ(covered.data()[i] != 0, zbuffer.depth.data()[i] > 0);
    }
  }
}

TEST(CpuRasterizerTest, GivesTheSameBytesForAnyNumberOfThreads) {
  ThreadPool one(1), two(2), seven(7);
  const auto a = make_cpu_rasterizer(one), b = make_cpu_rasterizer(two), c = make_cpu_rasterizer(seven);
  for (const Scene& scene : all_scenes()) {
    SCOPED_TRACE(scene.name);
    ZBuffer za, zb, zc;
    a->zbuffer(scene.grid(), scene.target, scene.footprint, za);
    b->zbuffer(scene.grid(), scene.target, scene.footprint, zb);
    c->zbuffer(scene.grid(), scene.target, scene.footprint, zc);
    EXPECT_EQ(za.winner, zb.winner);
    EXPECT_EQ(za.winner, zc.winner);
    EXPECT_EQ(za.depth, zc.depth);
    SoftSplat sa, sc;
    a->soft_splat(scene.grid(), &scene.colour, scene.target, {}, sa);
    c->soft_splat(scene.grid(), &scene.colour, scene.target, {}, sc);
    EXPECT_EQ(sa.depth, sc.depth);
    EXPECT_EQ(sa.valid, sc.valid);
  }
}

TEST(CpuRasterizerTest, LeavesNothingBehindForTheNextPicture) {
  ThreadPool pool(3);
  const auto reused = make_cpu_rasterizer(pool);
  for (int round = 0; round < 2; ++round)
    for (const Scene& scene : all_scenes()) {
      SCOPED_TRACE(scene.name);
      const auto fresh = make_cpu_rasterizer(pool);
      ZBuffer a, b;
      reused->zbuffer(scene.grid(), scene.target, scene.footprint, a);
      fresh->zbuffer(scene.grid(), scene.target, scene.footprint, b);
      EXPECT_EQ(a.winner, b.winner);
      EXPECT_EQ(a.depth, b.depth);
    }
}

TEST(CpuRasterizerTest, InvalidDepthsDrawNothing) {
  ThreadPool pool(1);
  const auto rasterizer = make_cpu_rasterizer(pool);
  const Camera camera = test_camera({8, 4}, 1.0);
  DepthMap depth(camera.size);
  const float bad[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1.0F, 0.0F};
  for (std::size_t i = 0; i < depth.size().pixels(); ++i) depth.data()[i] = bad[i % 4];
  ZBuffer out;
  rasterizer->zbuffer({camera, &depth, nullptr, nullptr}, test_camera({8, 4}, 1.0, {0.1, 0, 0}), {}, out);
  for (const std::uint32_t code : out.winner.pixels()) EXPECT_EQ(code, PointCode::none);
}

TEST(CpuRasterizerTest, EightKPicture) {
  ThreadPool pool;
  const auto rasterizer = make_cpu_rasterizer(pool);
  const Camera source = test_camera({7680, 4320}, 1.0);
  const DepthMap depth(source.size, 2.0F);
  ZBuffer out;
  rasterizer->zbuffer({source, &depth, nullptr, nullptr}, test_camera({7680, 4320}, 1.0, {0.01, 0, 0}), {}, out);
  // A plane parallel to the picture moves by fx * 0.01 / 2 = 35.147 pixels and keeps its size.
  EXPECT_EQ(out.winner(0, 0), PointCode::pack(35, 0));
  EXPECT_EQ(out.winner(7000, 4319), PointCode::pack(7035, 4319));
  EXPECT_EQ(out.winner(7679, 100), PointCode::none);
}

TEST(CpuRasterizerTest, RefusesWhatDoesNotFit) {
  ThreadPool pool(1);
  const auto rasterizer = make_cpu_rasterizer(pool);
  const Camera camera = test_camera({8, 4}, 1.0);
  const DepthMap wrong(4, 8, 1.0F), right(8, 4, 1.0F);
  ZBuffer out;
  EXPECT_THROW(rasterizer->zbuffer({camera, &wrong, nullptr, nullptr}, camera, {}, out), std::invalid_argument);
  EXPECT_THROW(rasterizer->zbuffer({camera, nullptr, nullptr, nullptr}, camera, {}, out), std::invalid_argument);
  Camera empty = camera;
  empty.size = {0, 4};
  EXPECT_THROW(rasterizer->zbuffer({camera, &right, nullptr, nullptr}, empty, {}, out), std::invalid_argument);
  Camera flat = camera;
  flat.intrinsics.fx = 0;
  EXPECT_THROW(rasterizer->zbuffer({flat, &right, nullptr, nullptr}, camera, {}, out), std::invalid_argument);
  EXPECT_THROW(rasterizer->zbuffer({camera, &right, nullptr, nullptr}, camera, {0.0F, 16.0F}, out),
               std::invalid_argument);
}

}  // namespace
}  // namespace uwv::testing
