// SPDX-License-Identifier: Apache-2.0
#include "pipeline/relative_depth.h"

#include <algorithm>

namespace uwv::pipeline {
namespace {

/// Depth maps that are known only where a reconstructed point was seen.
std::vector<DepthMap> sparse_depths(std::span<const ScenePoint> points, const std::vector<Camera>& cameras) {
  std::vector<DepthMap> depths(cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) depths[i] = DepthMap(cameras[i].size);
  for (const ScenePoint& point : points)
    for (const PointObservation& seen : point.observations) {
      const auto frame = static_cast<std::size_t>(seen.frame);
      const double z = (cameras[frame].cam_from_world() * point.x_in_world).z();
      const int x = static_cast<int>(seen.pixel.x()), y = static_cast<int>(seen.pixel.y());
      if (z > 0 && depths[frame].contains(x, y)) depths[frame](x, y) = static_cast<float>(z);
    }
  return depths;
}

}  // namespace

AlignmentOptions alignment_of(DepthKind kind) {
  require(is_relative(kind), "depth of a known unit needs no alignment");
  AlignmentOptions options;
  const bool inverse = kind == DepthKind::relative_inverse;
  options.model = inverse ? AlignmentModel::inverse_affine : AlignmentModel::depth_affine;
  options.relative = inverse ? RelativeDepth::inverse : RelativeDepth::depth;
  options.loss = AlignmentLoss::cauchy;  // points on edges land on the wrong side of them
  options.share = 1;                     // points are few
  options.smoothing = AlignmentSmoothing::joint;
  return options;
}

RelativeDepthOutcome bring_relative_depth_to_scale(std::span<const DepthMap> relative, const AlignmentOptions& options,
                                                   std::span<const ScenePoint> points, float believed,
                                                   SceneGeometry& scene, ThreadPool& pool, Monitor& monitor) {
  std::vector<DepthMap> reference;
  if (!points.empty())
    reference = sparse_depths(points, scene.cameras);
  else
    for (FrameGeometry& frame : scene.frames) reference.push_back(std::move(frame.depth));
  std::vector<AlignmentFrame> inputs(relative.size());
  for (std::size_t i = 0; i < relative.size(); ++i)
    inputs[i].relative = &relative[i], inputs[i].reference = &reference[i];
  RelativeDepthOutcome outcome;
  outcome.alignment = align_depth(inputs, options, pool, monitor);

  scene.frames.assign(relative.size(), {});
  for (std::size_t i = 0; i < relative.size(); ++i) {
    FrameGeometry& frame = scene.frames[i];
    frame.depth = aligned_depth(relative[i], outcome.alignment.frames[i], options);
    frame.confidence = ConfidenceMap(frame.depth.size());
    std::transform(frame.depth.pixels().begin(), frame.depth.pixels().end(), frame.confidence.pixels().begin(),
                   [believed](float z) { return z > 0 ? believed : 0.0F; });
  }
  const std::size_t solved = outcome.alignment.count(AlignmentStatus::solved);
  outcome.facts = {{"reference", points.empty() ? "prior" : "reconstructed points"},
                   {"brief", outcome.alignment.brief()},
                   {"solved_frames", solved}};
  if (solved == 0)
    monitor.warn("relative depth could not be brought to scale in any frame: " +
                 outcome.alignment.frames.front().reason);
  return outcome;
}

}  // namespace uwv::pipeline
