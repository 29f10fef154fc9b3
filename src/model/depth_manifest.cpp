// SPDX-License-Identifier: Apache-2.0
#include "model/depth_manifest.h"

#include <algorithm>
#include <string_view>

#include "uwv/core/error.h"

namespace uwv::model {
namespace {

using detail::JsonNode;

constexpr std::size_t most_frames = 1024;

constexpr std::array<std::pair<std::string_view, NetworkKind>, 4> kinds{
    {{"metric_depth", NetworkKind::metric_depth},
     {"inverse_depth", NetworkKind::inverse_depth},
     {"points", NetworkKind::points},
     {"depth_and_pose", NetworkKind::depth_and_pose}}};
constexpr std::array<std::pair<std::string_view, ConfidenceRule>, 3> confidence_rules{
    {{"unit", ConfidenceRule::unit}, {"logit", ConfidenceRule::logit}, {"from_one", ConfidenceRule::from_one}}};
constexpr std::array<std::pair<std::string_view, bool>, 2> units{{{"metric", true}, {"relative", false}}};
constexpr std::array<std::pair<std::string_view, bool>, 2> pose_directions{
    {{"cam_from_world", true}, {"world_from_cam", false}}};
constexpr std::array<std::pair<std::string_view, bool>, 2> view_fields{{{"each_frame", false}, {"first_frame", true}}};

Roles roles_of(NetworkKind kind) {
  switch (kind) {
    case NetworkKind::metric_depth: return {{"depth"}, {"confidence", "mask", "normals", "intrinsics"}};
    case NetworkKind::inverse_depth: return {{"inverse_depth"}, {"confidence", "mask"}};
    case NetworkKind::points: return {{"points"}, {"confidence", "mask", "normals", "metric_scale"}};
    case NetworkKind::depth_and_pose: return {{"depth", "pose"}, {"confidence", "mask"}};
  }
  return {};
}

void read_meanings(const JsonNode& node, DepthManifest& manifest) {
  const auto only_with = [&](const char* key, const char* role) {
    if (node.has(key) && manifest.outputs.count(role) == 0)
      node[key].complain(fmt::format("has no meaning without 'outputs/{}'", role));
    return node.has(key);
  };
  manifest.metric = manifest.kind == NetworkKind::metric_depth || manifest.outputs.count("metric_scale") > 0;
  if (node.has("unit")) {
    if (manifest.kind == NetworkKind::inverse_depth) node["unit"].complain("an inverse depth has none");
    manifest.metric = choice(node["unit"], units);
  }
  if (only_with("confidence_rule", "confidence"))
    manifest.confidence_rule = choice(node["confidence_rule"], confidence_rules);
  if (only_with("mask_rule", "mask")) manifest.mask_is_logit = choice(node["mask_rule"], mask_rules);
  if (only_with("mask_threshold", "mask")) manifest.mask_threshold = node["mask_threshold"].number({0, 1});
  if (only_with("pose_direction", "pose"))
    manifest.pose_is_cam_from_world = choice(node["pose_direction"], pose_directions);
  if (only_with("field_of_view", "pose")) manifest.one_field_of_view = choice(node["field_of_view"], view_fields);
  if (node.has("max_depth")) {
    if (manifest.kind == NetworkKind::inverse_depth) node["max_depth"].complain("goes with depths, not inverse ones");
    manifest.max_depth = node["max_depth"].number({0, 1e12, true});
  }
}

/// The last `blend` of the key frames must be the window's last frames, and the first its first: else the frames that
/// are blended would not show the same moments.
void check_keyframes(const JsonNode& node, const WindowRule& window) {
  bool fits = window.tied() == 0 || window.keyframes.front() == 0;
  for (int i = 0; i < window.blend; ++i)
    fits = fits && window.keyframes[static_cast<std::size_t>(window.tied() + i)] == window.frames - window.blend + i;
  if (!fits)
    node["keyframes"].complain(fmt::format("must begin with 0 and end with the window's last {} frames, {} to {}",
                                           window.blend, window.frames - window.blend, window.frames - 1));
}

WindowRule read_window(const JsonNode& node, const DepthManifest& manifest) {
  node.check_keys({"frames", "overlap", "blend", "keyframes"});
  if (!manifest.input.takes_clips()) node.complain("needs a T (the frames) in input/layout");
  if (manifest.kind != NetworkKind::inverse_depth && manifest.kind != NetworkKind::metric_depth)
    node.complain("goes with the kinds inverse_depth and metric_depth");
  WindowRule window;
  window.frames = static_cast<int>(node["frames"].integer(2, most_frames));
  window.overlap = static_cast<int>(node["overlap"].integer(1, window.frames / 2));
  window.blend = window.overlap;
  if (node.has("keyframes")) {
    if (node.has("blend")) window.blend = static_cast<int>(node["blend"].integer(1, window.overlap));
    const auto count = static_cast<std::size_t>(window.overlap);
    const auto list = node["keyframes"].elements(count, count, fmt::format("an array of 'overlap' = {} frames", count));
    for (const JsonNode& frame : list)
      window.keyframes.push_back(static_cast<int>(frame.integer(0, window.frames - 1)));
  } else {
    if (node.has("blend")) node["blend"].complain("needs 'keyframes': without them, all of the overlap is blended");
    for (int i = 0; i < window.overlap; ++i) window.keyframes.push_back(window.step() + i);
  }
  check_keyframes(node, window);
  return window;
}

}  // namespace

DepthManifest read_depth_manifest(const std::string& path) {
  const nlohmann::json json = read_manifest_json(path);
  const JsonNode root(json, "", path);
  root.check_keys({"format", "name", "model", "kind", "unit", "input", "outputs", "confidence_rule", "mask_rule",
                   "mask_threshold", "max_depth", "pose_direction", "field_of_view", "window"});
  DepthManifest manifest;
  manifest.path = path;
  read_shared_keys(root, manifest);
  manifest.kind = choice(root["kind"], kinds);
  manifest.input = read_input(root["input"]);
  read_outputs(root["outputs"], roles_of(manifest.kind), manifest);
  read_meanings(root, manifest);
  if (root.has("window")) manifest.window = read_window(root["window"], manifest);
  return manifest;
}

}  // namespace uwv::model
