// SPDX-License-Identifier: Apache-2.0
#include "bench/geometry_scores.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "bench/timing.h"
#include "uwv/eval/depth_metrics.h"
#include "uwv/eval/trajectory_error.h"

namespace uwv::bench {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// The median ratio of true and found depth over all frames; NaN without any.
double common_scale(std::span<const FrameGeometry> found, const TrueClip& truth) {
  std::vector<double> ratios;
  for (std::size_t f = 0; f < found.size(); ++f)
    for (std::size_t i = 0; i < truth.depths[f].pixels().size(); ++i) {
      const bool at_rest = truth.static_pixels.empty() || truth.static_pixels[f].pixels()[i] != 0;
      const double wanted = static_cast<double>(truth.depths[f].pixels()[i]);
      const double ours = static_cast<double>(found[f].depth.pixels()[i]);
      if (at_rest && wanted > 0 && ours > 0) ratios.push_back(wanted / ours);
    }
  return ratios.empty() ? nan : median(std::move(ratios));
}

DepthMap scaled(DepthMap depth, double scale) {
  for (float& z : depth.pixels()) z = static_cast<float>(scale * static_cast<double>(z));
  return depth;
}

/// Means over the pixels of all frames.
struct Pool {
  double pixels = 0, abs_rel = 0, delta_125 = 0;

  void add(const DepthErrors& errors) {
    if (errors.pixels == 0) return;
    const auto count = static_cast<double>(errors.pixels);
    pixels += count;
    abs_rel += count * errors.abs_rel;
    delta_125 += count * errors.delta_125;
  }
};

ValidityMask measured_pixels(const ConfidenceMap& confidence, const ValidityMask& at_rest) {
  ValidityMask measured = at_rest;
  for (std::size_t i = 0; i < measured.pixels().size(); ++i)
    if (confidence.pixels()[i] < 0.5F) measured.pixels()[i] = 0;
  return measured;
}

}  // namespace

CameraScore score_cameras(std::span<const Camera> found, std::span<const std::uint8_t> registered,
                          std::span<const Camera> truth) {
  std::vector<Rigid3> ours, theirs;
  for (std::size_t i = 0; i < std::min(found.size(), truth.size()); ++i) {
    if (!registered.empty() && registered[i] == 0) continue;
    ours.push_back(found[i].world_from_cam);
    theirs.push_back(truth[i].world_from_cam);
  }
  if (ours.size() < 3) return {static_cast<int>(ours.size()), nan, nan, nan, nan, nan};
  const TrajectoryError error = trajectory_error(ours, theirs);
  return {static_cast<int>(ours.size()),
          error.ate_rmse,
          100 * error.ate_rmse / error.truth_length,
          error.rotation_mean,
          100 * (found.front().intrinsics.fx / truth.front().intrinsics.fx - 1),
          error.truth_from_estimate.scale};
}

DepthScore score_depth(std::span<const FrameGeometry> found, const TrueClip& truth, double scale) {
  require(found.size() == truth.depths.size(), "{} depths were found for {} frames", found.size(), truth.depths.size());
  DepthScore score;
  score.scale = scale == 0 ? common_scale(found, truth) : scale;
  Pool all, measured;
  double wanted = 0;
  std::vector<DepthMap> depths;
  std::vector<DepthEdgeScore> edges;
  for (std::size_t f = 0; f < found.size(); ++f) {
    depths.push_back(scaled(found[f].depth, score.scale));
    const ValidityMask at_rest =
        truth.static_pixels.empty() ? ValidityMask(truth.depths[f].size(), 1) : truth.static_pixels[f];
    const ValidityMask sure = measured_pixels(found[f].confidence, at_rest);
    all.add(compare_depth(depths[f], truth.depths[f], DepthFit::none, &at_rest));
    measured.add(compare_depth(depths[f], truth.depths[f], DepthFit::none, &sure));
    edges.push_back(compare_depth_edges(depths[f], truth.depths[f], {}, &at_rest));
    for (std::size_t i = 0; i < at_rest.pixels().size(); ++i)
      wanted += at_rest.pixels()[i] != 0 && truth.depths[f].pixels()[i] > 0 ? 1 : 0;
  }
  score.abs_rel = all.abs_rel / all.pixels;
  score.measured_abs_rel = measured.abs_rel / measured.pixels;
  score.delta_125 = all.delta_125 / all.pixels;
  score.edge_f = pooled(edges).f;
  score.flicker = temporal_flicker(depths, truth.cameras, truth.static_pixels).mean;
  score.known = all.pixels / wanted;
  score.measured = measured.pixels / wanted;
  return score;
}

}  // namespace uwv::bench
