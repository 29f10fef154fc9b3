// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/decimation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "uwv/core/depth.h"
#include "uwv/eval/stock_scenes.h"

namespace uwv::testing {
namespace {

class DecimationTest : public ::testing::Test {
 protected:
  struct Filmed {
    StockScene stock;
    SyntheticFrame frame;
    std::vector<Camera> targets;
  };
  Filmed film(StockScene (*make)(const StockOptions&), Size size = {416, 240}, double unit = 1,
              const Eigen::Vector3d& origin = Eigen::Vector3d::Zero()) {
    StockOptions options;
    options.size = size;
    options.unit = unit;
    options.origin = origin;
    Filmed filmed{make(options), {}, {}};
    filmed.frame = render(filmed.stock.scene, filmed.stock.source, 0, pool_);
    for (const double degrees : {-10.0, 10.0})
      filmed.targets.push_back(
          orbit_camera(filmed.stock.source, filmed.stock.subject_in_world, degrees * std::numbers::pi / 180));
    return filmed;
  }
  ThreadPool pool_{2};
};

/// Where a world point lands; independent of how the library does it.
Eigen::Vector2d landing(const Camera& target, const Camera& source, const Eigen::Vector2d& pixel, double z) {
  Eigen::Vector2d out(std::nan(""), std::nan(""));
  project(target.intrinsics, target_from_source(target, source) * unproject(source.intrinsics, pixel, z), out);
  return out;
}

struct Check {
  double worst_px = 0;      ///< Largest shift over all pixels and targets.
  std::size_t covered = 0;  ///< Pixels that a cell stands for.
  std::size_t twice = 0;    ///< Pixels that more than one stands for.
};

Check check(const DecimatedDepth& points, const DepthMap& depth, const Camera& source,
            const std::vector<Camera>& targets) {
  Check result;
  Image<std::uint8_t> seen(depth.size());
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 0; x < depth.width(); ++x) {
      if (points.kept(x, y) == 0) continue;
      const int s = points.cell(x, y);
      for (int v = y - y % s; v < y - y % s + s; ++v)
        for (int u = x - x % s; u < x - x % s + s; ++u) {
          result.twice += seen(u, v);
          result.covered += 1 - seen(u, v);
          seen(u, v) = 1;
          const Slope& slope = points.slopes(x, y);
          const double w = (1 + static_cast<double>(slope.x) * (u - x) + static_cast<double>(slope.y) * (v - y)) /
                           static_cast<double>(points.depth(x, y));
          for (const Camera& target : targets) {
            const Eigen::Vector2d pixel(u + 0.5, v + 0.5);
            const Eigen::Vector2d exact = landing(target, source, pixel, depth(u, v));
            if (exact.allFinite())
              result.worst_px = std::max(result.worst_px, (landing(target, source, pixel, 1 / w) - exact).norm());
          }
        }
    }
  return result;
}

std::size_t valid_count(const DepthMap& depth) {
  return static_cast<std::size_t>(std::count_if(depth.pixels().begin(), depth.pixels().end(), is_valid_depth));
}

TEST_F(DecimationTest, EveryPixelIsStoodForOnceAndMovesLessThanTheBound) {
  for (auto* make : {sphere_floor_wall, boxes_room, slanted_planes, picket_fence, textured_plane, corridor})
    for (const double bound : {0.05, 0.5}) {
      const Filmed filmed = film(make);
      DecimationOptions options;
      options.max_error = bound;
      const DecimatedDepth points =
          decimate_depth(filmed.frame.depth, filmed.stock.source, filmed.targets, options, pool_);
      const Check got = check(points, filmed.frame.depth, filmed.stock.source, filmed.targets);
      EXPECT_LE(got.worst_px, bound * (1 + 1e-6)) << filmed.stock.name;
      EXPECT_EQ(got.covered, valid_count(filmed.frame.depth)) << filmed.stock.name;
      EXPECT_EQ(got.twice, 0U) << filmed.stock.name;
      EXPECT_NEAR(points.kept_share, static_cast<double>(points.kept.count()) / static_cast<double>(got.covered),
                  1e-12);
    }
}

TEST_F(DecimationTest, TargetsBetweenStayWithinTheBound) {
  const Filmed filmed = film(sphere_floor_wall);
  const DecimatedDepth points = decimate_depth(filmed.frame.depth, filmed.stock.source, filmed.targets, {}, pool_);
  const std::vector<Camera> between = {
      orbit_camera(filmed.stock.source, filmed.stock.subject_in_world, 5 * std::numbers::pi / 180)};
  EXPECT_LE(check(points, filmed.frame.depth, filmed.stock.source, between).worst_px, DecimationOptions{}.max_error);
}

TEST_F(DecimationTest, AFlatWallNeedsFewPointsAndAFenceOfBarsNearlyAll) {
  const Filmed wall = film(textured_plane);
  EXPECT_LT(decimate_depth(wall.frame.depth, wall.stock.source, wall.targets, {}, pool_).kept_share, 0.005);
  const Filmed room = film(boxes_room);
  EXPECT_LT(decimate_depth(room.frame.depth, room.stock.source, room.targets, {}, pool_).kept_share, 0.25);
  // Bars narrower than a pixel, 2.3 apart, the densest change there is; they fill the middle of the picture only.
  const Filmed fence = film(picket_fence, {208, 120});
  const DecimatedDepth points = decimate_depth(fence.frame.depth, fence.stock.source, fence.targets, {}, pool_);
  double kept = 0;
  for (int y = 32; y < 88; ++y)
    for (int x = 64; x < 144; ++x) kept += points.kept(x, y);
  EXPECT_GT(kept / (56 * 80), 0.9);
}

TEST_F(DecimationTest, NothingIsSavedWithoutLeave) {
  const Filmed filmed = film(sphere_floor_wall, {104, 60});
  DecimationOptions options;
  options.max_cell = 1;
  const DecimatedDepth points = decimate_depth(filmed.frame.depth, filmed.stock.source, filmed.targets, options, pool_);
  EXPECT_EQ(points.depth, filmed.frame.depth);
  EXPECT_EQ(points.kept_share, 1.0);
}

TEST_F(DecimationTest, ColoursDivideCells) {
  const Filmed wall = film(textured_plane);
  ImageRgb halves(wall.frame.depth.size(), Rgb8{10, 10, 10});
  for (int y = 0; y < halves.height(); ++y)
    for (int x = 101; x < halves.width(); ++x) halves(x, y) = {200, 10, 10};
  const DecimatedDepth points = decimate_depth(wall.frame.depth, wall.stock.source, wall.targets, {}, pool_, &halves);
  for (int y = 0; y < halves.height(); ++y)
    for (int x = 0; x < halves.width(); ++x)
      if (points.kept(x, y) != 0) {
        const int s = points.cell(x, y), x0 = x - x % s;
        EXPECT_FALSE(x0 < 101 && x0 + s > 101) << x << ' ' << y;
      }
}

TEST_F(DecimationTest, TheUnitOfLengthAndTheOriginDoNotMatter) {
  const Filmed filmed = film(sphere_floor_wall, {104, 60});
  const double share = decimate_depth(filmed.frame.depth, filmed.stock.source, filmed.targets, {}, pool_).kept_share;
  for (const auto& [unit, offset] : {std::pair{1e-6, 0.0}, std::pair{1e9, 0.0}, std::pair{1.0, 1e7}}) {
    const Filmed other = film(sphere_floor_wall, {104, 60}, unit, {offset, -offset, offset});
    const DecimatedDepth points = decimate_depth(other.frame.depth, other.stock.source, other.targets, {}, pool_);
    EXPECT_NEAR(points.kept_share, share, 0.01) << "unit " << unit << ", offset " << offset;
    EXPECT_LE(check(points, other.frame.depth, other.stock.source, other.targets).worst_px, 0.2501);
  }
}

TEST_F(DecimationTest, InvalidDepthIsNeverPartOfACell) {
  const Filmed filmed = film(textured_plane, {104, 60});
  DepthMap depth = filmed.frame.depth;
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  depth(10, 10) = 0, depth(33, 20) = nan, depth(50, 50) = inf, depth(70, 5) = -1;
  const DecimatedDepth points = decimate_depth(depth, filmed.stock.source, filmed.targets, {}, pool_);
  const Check got = check(points, depth, filmed.stock.source, filmed.targets);
  EXPECT_EQ(got.covered, depth.pixels().size() - 4);
  EXPECT_LE(got.worst_px, 0.2501);
  for (const float z : points.depth.pixels()) EXPECT_TRUE(z == 0 || is_valid_depth(z));
}

TEST_F(DecimationTest, ExtremesAreAnswered) {
  Camera one;
  one.intrinsics = Intrinsics::from_fov_x(1, {1, 1});
  one.size = {1, 1};
  const std::vector<Camera> targets{one};
  EXPECT_EQ(decimate_depth(DepthMap(1, 1, 2.0F), one, targets, {}, pool_).kept_share, 1.0);
  EXPECT_EQ(decimate_depth(DepthMap(1, 1, 0.0F), one, targets, {}, pool_).kept_share, 0.0);
  EXPECT_EQ(decimate_depth(DepthMap(), Camera{}, {}, {}, pool_).kept.count(), 0U);
  EXPECT_THROW(decimate_depth(DepthMap(2, 1, 1.0F), one, targets, {}, pool_), std::invalid_argument);
  EXPECT_THROW((DecimationOptions{.max_cell = 12}.check()), std::invalid_argument);
  EXPECT_THROW((DecimationOptions{.max_error = std::nan("")}.check()), std::invalid_argument);
}

TEST_F(DecimationTest, ThreadsDoNotChangeTheResult) {
  const Filmed filmed = film(sphere_floor_wall);
  ThreadPool one(1), five(5);
  const DecimatedDepth a = decimate_depth(filmed.frame.depth, filmed.stock.source, filmed.targets, {}, one);
  const DecimatedDepth b = decimate_depth(filmed.frame.depth, filmed.stock.source, filmed.targets, {}, five);
  EXPECT_EQ(a.cell, b.cell);
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_EQ(a.slopes, b.slopes);
}

}  // namespace
}  // namespace uwv::testing
