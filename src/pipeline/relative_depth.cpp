// SPDX-License-Identifier: Apache-2.0
#include "pipeline/relative_depth.h"

#include <algorithm>

#include "uwv/geometry/depth_alignment.h"

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

AlignmentOptions alignment_options(DepthKind kind) {
  AlignmentOptions options;
  const bool inverse = kind == DepthKind::relative_inverse;
  options.model = inverse ? AlignmentModel::inverse_affine : AlignmentModel::depth_affine;
  options.relative = inverse ? RelativeDepth::inverse : RelativeDepth::depth;
  options.loss = AlignmentLoss::cauchy;  // points on edges land on the wrong side of them
  options.share = 1;                     // points are few
  options.smoothing = AlignmentSmoothing::joint;
  return options;
}

}  // namespace

RelativeDepthOutcome bring_relative_depth_to_scale(std::span<const ImageRgb> frames, std::span<const DepthMap> relative,
                                                   DepthKind kind, std::span<const ScenePoint> points,
                                                   SceneGeometry& scene, ThreadPool& pool, Monitor& monitor) {
  std::vector<DepthMap> reference;
  if (!points.empty())
    reference = sparse_depths(points, scene.cameras);
  else
    for (FrameGeometry& frame : scene.frames) reference.push_back(std::move(frame.depth));
  std::vector<AlignmentFrame> inputs(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i)
    inputs[i].relative = &relative[i], inputs[i].reference = &reference[i];
  const AlignmentOptions options = alignment_options(kind);
  const AlignmentSummary summary = align_depth(inputs, options, pool, monitor);

  constexpr float believed = 0.5F;  // another's estimate, at a scale that was measured
  scene.frames.assign(frames.size(), {});
  for (std::size_t i = 0; i < frames.size(); ++i) {
    FrameGeometry& frame = scene.frames[i];
    frame.depth = aligned_depth(relative[i], summary.frames[i], options);
    frame.confidence = ConfidenceMap(frame.depth.size());
    std::transform(frame.depth.pixels().begin(), frame.depth.pixels().end(), frame.confidence.pixels().begin(),
                   [](float z) { return z > 0 ? believed : 0.0F; });
  }
  scene.depth_from = GeometryProvider::import;
  RelativeDepthOutcome outcome;
  outcome.brief = summary.brief();
  outcome.facts = {{"reference", points.empty() ? "prior" : "reconstructed points"}, {"brief", summary.brief()}};
  const auto solved = std::count_if(summary.frames.begin(), summary.frames.end(),
                                    [](const FrameAlignment& f) { return f.status == AlignmentStatus::solved; });
  outcome.facts["solved_frames"] = solved;
  if (solved == 0)
    monitor.warn("relative depth could not be brought to scale in any frame: " + summary.frames.front().reason);
  return outcome;
}

}  // namespace uwv::pipeline
