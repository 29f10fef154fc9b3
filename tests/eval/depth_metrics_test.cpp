// SPDX-License-Identifier: Apache-2.0
// Depth metrics by known numbers, and by scenes whose depth is exact.
#include "uwv/eval/depth_metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "uwv/eval/stock_scenes.h"

namespace uwv::testing {
namespace {

constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();

DepthMap row(const std::vector<float>& values) {
  DepthMap out(static_cast<int>(values.size()), 1);
  std::copy(values.begin(), values.end(), out.data());
  return out;
}

TEST(DepthMetrics, known_numbers) {
  const DepthErrors errors = compare_depth(row({1, 2.5F, 4, 0, 7}), row({1, 2, 5, 3, 0}));
  EXPECT_EQ(errors.pixels, 3U);
  EXPECT_DOUBLE_EQ(errors.valid_share, 0.75);
  EXPECT_NEAR(errors.abs_rel, (0 + 0.25 + 0.2) / 3, 1e-12);
  EXPECT_NEAR(errors.rmse, std::sqrt((0 + 0.25 + 1) / 3), 1e-12);
  EXPECT_NEAR(errors.delta_125, 1.0 / 3, 1e-12);  // 1.25 itself is outside
}

TEST(DepthMetrics, forgives_what_it_is_told_to) {
  DepthMap truth(40, 30), scaled(40, 30), relative(40, 30);
  for (std::size_t p = 0; p < truth.pixels().size(); ++p) {
    const double z = 1 + 0.01 * static_cast<double>(p);
    truth.pixels()[p] = static_cast<float>(z);
    scaled.pixels()[p] = static_cast<float>(z / 7);
    relative.pixels()[p] = static_cast<float>(1 / (0.5 / z + 0.2));
  }
  EXPECT_GT(compare_depth(scaled, truth).abs_rel, 0.8);
  const DepthErrors by_scale = compare_depth(scaled, truth, DepthFit::scale);
  EXPECT_LT(by_scale.abs_rel, 1e-6);
  EXPECT_NEAR(by_scale.scale, 7, 1e-5);
  EXPECT_GT(compare_depth(relative, truth, DepthFit::scale).abs_rel, 0.05);
  const DepthErrors by_line = compare_depth(relative, truth, DepthFit::scale_shift);
  EXPECT_LT(by_line.abs_rel, 1e-5);
  EXPECT_NEAR(by_line.scale, 2, 1e-4);
  EXPECT_NEAR(by_line.shift, -0.4, 1e-4);
  EXPECT_EQ(by_line.delta_125, 1);
}

TEST(DepthMetrics, units_do_not_matter_but_for_rmse) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> depth(1, 5);
  DepthMap a(20, 20), b(20, 20);
  for (std::size_t p = 0; p < a.pixels().size(); ++p) {
    a.pixels()[p] = depth(random);
    b.pixels()[p] = depth(random);
  }
  for (const DepthFit fit : {DepthFit::none, DepthFit::scale, DepthFit::scale_shift}) {
    const DepthErrors one = compare_depth(a, b, fit);
    for (const float unit : {0x1p-26F, 0x1p26F}) {
      DepthMap far_a = a, far_b = b;
      for (float& z : far_a.pixels()) z *= unit;
      for (float& z : far_b.pixels()) z *= unit;
      const DepthErrors other = compare_depth(far_a, far_b, fit);
      EXPECT_NEAR(other.abs_rel, one.abs_rel, 1e-9 * one.abs_rel);
      EXPECT_NEAR(other.rmse, one.rmse * static_cast<double>(unit), 1e-9 * one.rmse * static_cast<double>(unit));
      EXPECT_EQ(other.pixels, one.pixels);
    }
  }
}

TEST(DepthMetrics, mask_and_invalid_values_are_left_out) {
  ValidityMask mask(4, 1, std::uint8_t{1});
  mask(3, 0) = 0;
  const DepthErrors errors = compare_depth(
      row({2, nan_value, 3, 9}), row({2, 2, std::numeric_limits<float>::infinity(), 1}), DepthFit::none, &mask);
  EXPECT_EQ(errors.pixels, 1U);
  EXPECT_DOUBLE_EQ(errors.valid_share, 0.5);
  EXPECT_EQ(errors.abs_rel, 0);
}

TEST(DepthMetrics, nothing_to_compare_is_nan_and_flat_depth_falls_back) {
  for (const DepthFit fit : {DepthFit::none, DepthFit::scale, DepthFit::scale_shift}) {
    EXPECT_TRUE(std::isnan(compare_depth({}, {}, fit).abs_rel));
    EXPECT_TRUE(std::isnan(compare_depth(row({0, 1}), row({1, 0}), fit).rmse));
    EXPECT_EQ(compare_depth(row({0, 1}), row({1, 0}), fit).valid_share, 0);
  }
  const DepthErrors flat = compare_depth(row({2, 2}), row({4, 4}), DepthFit::scale_shift);
  EXPECT_EQ(flat.scale, 2);
  EXPECT_EQ(flat.abs_rel, 0);
  EXPECT_THROW(compare_depth(row({1}), row({1, 2})), std::invalid_argument);
}

DepthMap step_at(int column) {
  DepthMap depth(40, 20, 4.0F);
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < column; ++x) depth(x, y) = 2;
  return depth;
}

TEST(DepthMetrics, edges_within_the_tolerance_are_found) {
  const DepthMap truth = step_at(20);
  DepthEdgeOptions options;
  options.tolerance = 2;
  for (const int shift : {-3, -2, 0, 2, 3}) {
    const DepthEdgeScore score = compare_depth_edges(step_at(20 + shift), truth, options);
    EXPECT_EQ(score.true_edges, 20U);
    EXPECT_EQ(score.estimated, 20U);
    EXPECT_EQ(score.f, std::abs(shift) <= 2 ? 1 : 0) << shift;
  }
  DepthMap half = truth;
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 20; ++x) half(x, y) = 4;
  const DepthEdgeScore score = compare_depth_edges(half, truth);
  EXPECT_NEAR(score.recall, 0.5, 0.06);
  EXPECT_LT(score.f, 0.75);
}

TEST(DepthMetrics, flat_pictures_have_no_edges_and_blur_loses_them) {
  EXPECT_EQ(compare_depth_edges(DepthMap(5, 5, 1.0F), DepthMap(5, 5, 2.0F)).f, 1);
  EXPECT_EQ(compare_depth_edges({}, {}).f, 1);
  EXPECT_EQ(compare_depth_edges(DepthMap(40, 20, 1.0F), step_at(20)).f, 0);
  DepthMap ramp = step_at(20);
  for (int y = 0; y < 20; ++y)
    for (int x = 10; x < 30; ++x) ramp(x, y) = static_cast<float>(2 + 0.1 * (x - 10));
  EXPECT_EQ(compare_depth_edges(ramp, step_at(20)).recall, 0);
}

TEST(DepthMetrics, edges_outside_the_mask_or_the_truth_are_not_judged) {
  DepthMap estimate = step_at(20);
  for (int y = 0; y < 20; ++y) estimate(5, y) = 1;  // a pole that is not there
  EXPECT_NEAR(compare_depth_edges(estimate, step_at(20)).precision, 0.5, 1e-12);
  ValidityMask mask(40, 20, 1);
  for (int y = 0; y < 20; ++y) mask(5, y) = 0;
  EXPECT_EQ(compare_depth_edges(estimate, step_at(20), {}, &mask).f, 1);
  DepthMap unknown = step_at(20);
  for (int y = 0; y < 20; ++y) unknown(5, y) = 0;
  EXPECT_EQ(compare_depth_edges(estimate, unknown).f, 1);
  const ValidityMask small(3, 3, 1);
  EXPECT_THROW(compare_depth_edges(estimate, unknown, {}, &small), std::invalid_argument);
}

TEST(DepthMetrics, pooled_edges_count_by_edges_not_by_pictures) {
  DepthEdgeScore many, few, none = compare_depth_edges(DepthMap(5, 5, 1.0F), DepthMap(5, 5, 1.0F));
  many.estimated = 90, many.true_edges = 80, many.precision = 1, many.recall = 0.5;
  few.estimated = 10, few.true_edges = 20, few.precision = 0, few.recall = 1;
  const std::vector<DepthEdgeScore> scores{many, none, few};
  const DepthEdgeScore all = pooled(scores);
  EXPECT_EQ(all.estimated, 100U);
  EXPECT_EQ(all.true_edges, 100U);
  EXPECT_NEAR(all.precision, 0.9, 1e-12);
  EXPECT_NEAR(all.recall, 0.6, 1e-12);
  EXPECT_NEAR(all.f, 2 * 0.9 * 0.6 / 1.5, 1e-12);
  EXPECT_EQ(pooled({}).f, 1);
}

/// Exact depth of a ball before a wall from cameras on an orbit.
struct Orbit {
  std::vector<DepthMap> depth;
  std::vector<Camera> cameras;
  explicit Orbit(double unit = 1, const Eigen::Vector3d& origin = Eigen::Vector3d::Zero()) {
    StockOptions options;
    options.size = {160, 96};
    options.unit = unit;
    options.origin = origin;
    const StockScene stock = sphere_floor_wall(options);
    ThreadPool pool(1);
    for (int i = 0; i < 4; ++i) {
      cameras.push_back(orbit_camera(stock.source, stock.subject_in_world, 0.01 * i));
      depth.push_back(render(stock.scene, cameras.back(), 0, pool).depth);
    }
  }
};

TEST(DepthMetrics, exact_depth_does_not_flicker) {
  for (const double unit : {1e-3, 1.0, 1e4}) {
    const Orbit orbit(unit, {1e3 * unit, 0, 0});
    const DepthFlicker flicker = temporal_flicker(orbit.depth, orbit.cameras);
    EXPECT_GT(flicker.points, 30000U);
    EXPECT_LT(flicker.mean, 2e-4);
    EXPECT_LT(flicker.jump_share, 0.02);
  }
}

TEST(DepthMetrics, flicker_measures_breathing_and_respects_masks) {
  Orbit orbit;
  for (std::size_t i = 0; i < orbit.depth.size(); ++i)
    for (float& z : orbit.depth[i].pixels()) z *= i % 2 == 0 ? 1.0F : 1.05F;
  const DepthFlicker flicker = temporal_flicker(orbit.depth, orbit.cameras);
  EXPECT_NEAR(flicker.mean, 0.05, 0.005);
  EXPECT_NEAR(flicker.bias, 0.05 / 3, 0.005);  // up, down, up

  // What moves is masked: half of the picture comes closer by a tenth each frame.
  Orbit moving;
  std::vector<ValidityMask> at_rest;
  for (std::size_t i = 0; i < moving.depth.size(); ++i) {
    ValidityMask mask(moving.depth[i].size(), std::uint8_t{1});
    for (int y = 0; y < mask.height(); ++y)
      for (int x = 0; x < 80; ++x) {
        moving.depth[i](x, y) *= static_cast<float>(1 - 0.1 * static_cast<double>(i));
        mask(x, y) = 0;
      }
    at_rest.push_back(mask);
  }
  EXPECT_GT(temporal_flicker(moving.depth, moving.cameras).mean, 0.02);
  EXPECT_LT(temporal_flicker(moving.depth, moving.cameras, at_rest).mean, 2e-3);
}

TEST(DepthMetrics, flicker_of_nothing_is_nan_and_wrong_input_is_refused) {
  EXPECT_TRUE(std::isnan(temporal_flicker({}, {}).mean));
  const Orbit orbit;
  const std::vector<DepthMap> holes(2, DepthMap(160, 96, nan_value));
  const DepthFlicker none = temporal_flicker(holes, std::span(orbit.cameras).first(2));
  EXPECT_TRUE(std::isnan(none.mean));
  EXPECT_EQ(none.points, 0U);
  EXPECT_THROW(temporal_flicker(orbit.depth, std::span(orbit.cameras).first(2)), std::invalid_argument);
  const std::vector<ValidityMask> masks(1);
  EXPECT_THROW(temporal_flicker(orbit.depth, orbit.cameras, masks), std::invalid_argument);
  const DepthMap dot(1, 1, 2.0F);
  const Camera camera{Intrinsics{1, 1, 0.5, 0.5}, {}, {1, 1}};
  EXPECT_EQ(temporal_flicker(std::vector{dot, dot}, std::vector{camera, camera}).mean, 0);
}

}  // namespace
}  // namespace uwv::testing
