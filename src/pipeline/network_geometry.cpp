// SPDX-License-Identifier: Apache-2.0
#include "pipeline/network_geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/relative_depth.h"
#include "uwv/geometry/depth_alignment.h"

namespace uwv::pipeline {
namespace {

using nlohmann::ordered_json;

constexpr const char* name_of(NetworkDepth meaning) {
  switch (meaning) {
    case NetworkDepth::metric: return "metres";
    case NetworkDepth::up_to_scale: return "up to one scale";
    default: return "inverse, up to scale and shift";
  }
}

/// The network's maps as the alignment reads them: 0 = unknown. An affine inverse depth may be 0 or negative, so all of
/// it is raised above 0, which the fitted shift takes back.
std::vector<DepthMap> relative_maps(const DepthNetworkResult& seen) {
  const bool inverse = seen.meaning == NetworkDepth::inverse_affine;
  float least = std::numeric_limits<float>::max(), most = std::numeric_limits<float>::lowest();
  for (const FrameGeometry& frame : seen.frames)
    for (std::size_t p = 0; p < frame.depth.pixels().size(); ++p) {
      const float value = frame.depth.pixels()[p];
      if (frame.confidence.pixels()[p] <= 0 || !std::isfinite(value)) continue;
      least = std::min(least, value);
      most = std::max(most, value);
    }
  constexpr float margin = 1e-3F;  // of the range: clear of 0, of which a float keeps seven digits
  const float raise = inverse && most >= least ? margin * std::max(most - least, std::abs(most)) - least : 0;
  std::vector<DepthMap> maps;
  for (const FrameGeometry& frame : seen.frames) {
    DepthMap& map = maps.emplace_back(frame.depth.size());
    for (std::size_t p = 0; p < map.pixels().size(); ++p) {
      const float value = frame.depth.pixels()[p];
      if (frame.confidence.pixels()[p] > 0 && std::isfinite(value)) map.pixels()[p] = value + raise;
    }
  }
  return maps;
}

AlignmentOptions alignment_of(const DepthNetworkResult& seen) {
  AlignmentOptions options;
  const bool inverse = seen.meaning == NetworkDepth::inverse_affine;
  options.model = inverse ? AlignmentModel::inverse_affine : AlignmentModel::depth_scale;
  options.relative = inverse ? RelativeDepth::inverse : RelativeDepth::depth;
  options.loss = AlignmentLoss::cauchy;
  options.share = 1;  // reconstructed points are few
  // A network that sees each frame alone errs anew each time: its lines do not hang together.
  options.smoothing = seen.consistent ? AlignmentSmoothing::joint : AlignmentSmoothing::none;
  if (seen.consistent) options.smooth_frames = std::max<double>(options.smooth_frames, seen.frames.size());
  return options;
}

/// The scale in the middle of all frames'; 0 when no frame has one.
double median_scale(const AlignmentSummary& alignment) {
  std::vector<double> scales;
  for (const FrameAlignment& frame : alignment.frames)
    if (frame.usable && frame.line.scale > 0) scales.push_back(frame.line.scale);
  if (scales.empty()) return 0;
  const auto middle = scales.begin() + static_cast<std::ptrdiff_t>(scales.size() / 2);
  std::nth_element(scales.begin(), middle, scales.end());
  return *middle;
}

void multiply_unit(SceneGeometry& scene, double factor) {
  for (Camera& camera : scene.cameras) camera.world_from_cam.translation *= factor;
  for (FrameGeometry& frame : scene.frames)
    for (float& z : frame.depth.pixels()) z = static_cast<float>(z * factor);
}

}  // namespace

NetworkGeometry::NetworkGeometry(DepthNetwork& network, std::span<const ImageRgb> frames, ThreadPool& pool,
                                 Monitor& monitor)
    : network_(network), pool_(pool), monitor_(monitor), seen_(network.run(frames, {}, pool, monitor)) {
  const Size input = network.input_size(frames.front().size());
  facts_ = {{"name", network.name()},
            {"input_size", fmt::format("{}x{}", input.width, input.height)},
            {"depth", name_of(seen_.meaning)},
            {"one_scale_for_all_frames", seen_.consistent},
            {"gives_lens", !seen_.intrinsics.empty()},
            {"gives_cameras", has_cameras()},
            {"seconds", seen_.seconds},
            {"notes", seen_.notes}};
}

std::optional<Intrinsics> NetworkGeometry::lens() const {
  if (seen_.intrinsics.empty()) return std::nullopt;
  std::vector<Intrinsics> all = seen_.intrinsics;
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end(),
                   [](const Intrinsics& a, const Intrinsics& b) { return a.fx < b.fx; });
  return *middle;
}

std::vector<Camera> NetworkGeometry::cameras(const std::optional<Intrinsics>& known) const {
  require(has_cameras(), "the network '{}' gives no cameras", network_.name());
  std::vector<Camera> cameras;
  const Size size = seen_.frames.front().depth.size();
  const Intrinsics lens = known ? *known : this->lens().value_or(Intrinsics{});
  for (std::size_t i = 0; i < seen_.frames.size(); ++i)
    cameras.push_back({known || seen_.intrinsics.empty() ? lens : seen_.intrinsics[i], seen_.world_from_cam[i], size});
  return cameras;
}

void NetworkGeometry::place(std::span<const ScenePoint> points, bool standing, SceneGeometry& scene) {
  scene.depth_from = GeometryProvider::network;
  if (has_cameras() || (points.empty() && !needs_reference())) {
    take_as_is(scene);
    if (!has_cameras() && standing && !seen_.consistent) steady(scene);
  } else {
    align(points, scene);
  }
  keep_confidence(scene);
  scene.normals = seen_.normals;
}

void NetworkGeometry::take_as_is(SceneGeometry& scene) const {
  scene.frames.assign(seen_.frames.begin(), seen_.frames.end());
}

void NetworkGeometry::align(std::span<const ScenePoint> points, SceneGeometry& scene) {
  const RelativeDepthOutcome outcome =
      bring_relative_depth_to_scale(relative_maps(seen_), alignment_of(seen_), points, 1, scene, pool_, monitor_);
  facts_["alignment"] = outcome.facts;
  const double units_per_metre = seen_.meaning == NetworkDepth::metric ? median_scale(outcome.alignment) : 0;
  if (units_per_metre > 0) multiply_unit(scene, 1 / units_per_metre);
  facts_["unit"] = units_per_metre > 0 ? "metres" : "the cameras'";
}

/// Each frame's scale is fitted to the first frame's depth; what moved is outvoted.
void NetworkGeometry::steady(SceneGeometry& scene) {
  const DepthMap first = scene.frames.front().depth;
  std::vector<AlignmentFrame> inputs(scene.frames.size());
  for (std::size_t i = 0; i < inputs.size(); ++i)
    inputs[i].relative = &scene.frames[i].depth, inputs[i].reference = &first;
  const AlignmentOptions options = alignment_of(seen_);
  const AlignmentSummary summary = align_depth(inputs, options, pool_, monitor_);
  for (std::size_t i = 0; i < inputs.size(); ++i)
    scene.frames[i].depth = aligned_depth(scene.frames[i].depth, summary.frames[i], options);
  facts_["alignment"] = {{"reference", "the first frame"}, {"brief", summary.brief()}};
}

/// What the network said of each pixel it still has a depth for.
void NetworkGeometry::keep_confidence(SceneGeometry& scene) const {
  for (std::size_t i = 0; i < scene.frames.size(); ++i) {
    FrameGeometry& frame = scene.frames[i];
    frame.confidence = seen_.frames[i].confidence;
    for (std::size_t p = 0; p < frame.depth.pixels().size(); ++p)
      if (!(frame.depth.pixels()[p] > 0)) frame.confidence.pixels()[p] = 0;
  }
}

std::vector<DepthMap> NetworkGeometry::behind(std::span<const ImageRgb> background,
                                              std::span<const ForegroundMask> foreground, const SceneGeometry& scene) {
  const DepthNetworkResult seen = network_.run(background, {}, pool_, monitor_);
  const std::vector<DepthMap> relative = relative_maps(seen);
  std::vector<ValidityMask> unhidden;
  for (const ForegroundMask& mask : foreground) {
    ValidityMask& open = unhidden.emplace_back(mask.size());
    std::transform(mask.pixels().begin(), mask.pixels().end(), open.pixels().begin(),
                   [](std::uint8_t inside) { return static_cast<std::uint8_t>(inside == 0); });
  }
  std::vector<AlignmentFrame> inputs(relative.size());
  for (std::size_t i = 0; i < inputs.size(); ++i)
    inputs[i] = {.relative = &relative[i], .reference = &scene.frames[i].depth, .mask = &unhidden[i], .weights = {}};
  AlignmentOptions options = alignment_of(seen);
  options.share = AlignmentOptions{}.share;
  const AlignmentSummary summary = align_depth(inputs, options, pool_, monitor_);
  facts_["background_alignment"] = summary.brief();
  std::vector<DepthMap> depths;
  for (std::size_t i = 0; i < relative.size(); ++i)
    depths.push_back(aligned_depth(relative[i], summary.frames[i], options));
  return depths;
}

}  // namespace uwv::pipeline
