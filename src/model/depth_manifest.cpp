// SPDX-License-Identifier: Apache-2.0
#include "model/depth_manifest.h"

#include <algorithm>
#include <string_view>

#include "io/disk_file.h"
#include "io/json_text.h"
#include "trajectory/json_node.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

using detail::JsonNode;

constexpr long largest_side = 16384;
constexpr std::size_t most_frames = 1024;

template <class Enum, std::size_t N>
Enum choice(const JsonNode& node, const std::array<std::pair<std::string_view, Enum>, N>& choices) {
  std::vector<std::string_view> names;
  for (const auto& [name, value] : choices) names.push_back(name);
  const std::string text = node.text(names);
  for (const auto& [name, value] : choices)
    if (name == text) return value;
  return choices.front().second;  // not reached: text() refuses other words
}

constexpr std::array<std::pair<std::string_view, NetworkKind>, 4> kinds{
    {{"metric_depth", NetworkKind::metric_depth},
     {"inverse_depth", NetworkKind::inverse_depth},
     {"points", NetworkKind::points},
     {"depth_and_pose", NetworkKind::depth_and_pose}}};
constexpr std::array<std::pair<std::string_view, SizeRule>, 5> size_rules{{{"fixed", SizeRule::fixed},
                                                                           {"shorter_side", SizeRule::shorter_side},
                                                                           {"longer_side", SizeRule::longer_side},
                                                                           {"width", SizeRule::width},
                                                                           {"area", SizeRule::area}}};
constexpr std::array<std::pair<std::string_view, Rounding>, 3> roundings{
    {{"nearest", Rounding::nearest}, {"down", Rounding::down}, {"up", Rounding::up}}};
constexpr std::array<std::pair<std::string_view, InputFilter>, 4> filters{{{"bilinear", InputFilter::bilinear},
                                                                           {"bicubic", InputFilter::bicubic},
                                                                           {"area", InputFilter::area},
                                                                           {"lanczos", InputFilter::lanczos}}};
constexpr std::array<std::pair<std::string_view, bool>, 2> channel_orders{{{"rgb", false}, {"bgr", true}}};
constexpr std::array<std::pair<std::string_view, TensorType>, 3> dtypes{
    {{"float32", TensorType::float32}, {"bfloat16", TensorType::bfloat16}, {"float16", TensorType::float16}}};
constexpr std::array<std::pair<std::string_view, ConfidenceRule>, 3> confidence_rules{
    {{"unit", ConfidenceRule::unit}, {"logit", ConfidenceRule::logit}, {"from_one", ConfidenceRule::from_one}}};
constexpr std::array<std::pair<std::string_view, bool>, 2> mask_rules{{{"probability", false}, {"logit", true}}};
constexpr std::array<std::pair<std::string_view, bool>, 2> units{{{"metric", true}, {"relative", false}}};
constexpr std::array<std::pair<std::string_view, bool>, 2> pose_directions{
    {{"cam_from_world", true}, {"world_from_cam", false}}};
constexpr std::array<std::pair<std::string_view, bool>, 2> view_fields{{{"each_frame", false}, {"first_frame", true}}};

std::array<double, 3> triple(const JsonNode& node, detail::Range range) {
  const auto values = node.numbers(3, 3, range);
  return {values[0], values[1], values[2]};
}

void read_size_rule(const JsonNode& node, InputRule& rule) {
  rule.size_rule = choice(node["resize"], size_rules);
  const std::string_view wanted = rule.size_rule == SizeRule::fixed  ? "size"
                                  : rule.size_rule == SizeRule::area ? "pixels"
                                                                     : "side";
  for (const std::string_view key : {"size", "pixels", "side"})
    if (key != wanted && node.has(key))
      node.complain(fmt::format("'{}' has no meaning with this 'resize', which goes with '{}'", key, wanted));
  if (wanted == "size") {
    const auto sides = node["size"].elements(2, 2, "an array [width, height]");
    rule.size = {static_cast<int>(sides[0].integer(1, largest_side)),
                 static_cast<int>(sides[1].integer(1, largest_side))};
  } else if (wanted == "pixels") {
    rule.pixels = static_cast<double>(node["pixels"].integer(1, largest_side * largest_side));
  } else {
    rule.side = static_cast<int>(node["side"].integer(1, largest_side));
  }
  if (node.has("multiple_of")) rule.multiple_of = static_cast<int>(node["multiple_of"].integer(1, 1024));
  if (node.has("round")) rule.rounding = choice(node["round"], roundings);
  if (!node.has("limit_aspect")) return;
  if (rule.size_rule != SizeRule::shorter_side) node["limit_aspect"].complain("goes with resize 'shorter_side' only");
  rule.limit_aspect = node["limit_aspect"].number({1, 1000});
}

std::string read_layout(const JsonNode& node) {
  const std::string layout = node.text();
  const auto count = [&](char letter) { return std::count(layout.begin(), layout.end(), letter); };
  const bool letters_fit = layout.size() <= 5 && layout.find_first_not_of("NTCHW") == std::string::npos &&
                           count('C') == 1 && count('H') == 1 && count('W') == 1 && count('N') <= 1 && count('T') <= 1;
  if (!letters_fit || (count('T') == 1 && layout.find('T') > layout.find_first_of("CHW")))
    node.refuse("each of C, H, W once, and before them N (a 1) or T (the frames) or both, e.g. NCHW or NTCHW");
  return layout;
}

InputRule read_input(const JsonNode& node) {
  node.check_keys({"resize", "side", "size", "pixels", "multiple_of", "round", "limit_aspect", "filter", "channels",
                   "range", "mean", "std", "layout", "dtype"});
  InputRule rule;
  read_size_rule(node, rule);
  if (node.has("filter")) rule.filter = choice(node["filter"], filters);
  if (node.has("channels")) rule.bgr = choice(node["channels"], channel_orders);
  if (node.has("range")) {
    const auto ends = node["range"].numbers(2, 2, {-1e6, 1e6});
    rule.range = {ends[0], ends[1]};
  }
  if (node.has("mean")) rule.mean = triple(node["mean"], {-1e6, 1e6});
  if (node.has("std")) rule.std = triple(node["std"], {0, 1e6, true});
  if (node.has("layout")) rule.layout = read_layout(node["layout"]);
  if (node.has("dtype")) rule.dtype = choice(node["dtype"], dtypes);
  return rule;
}

/// The roles a kind must have, then those it may have.
struct Roles {
  std::vector<std::string_view> needed, possible;
};

Roles roles_of(NetworkKind kind) {
  switch (kind) {
    case NetworkKind::metric_depth: return {{"depth"}, {"confidence", "mask", "normals", "intrinsics"}};
    case NetworkKind::inverse_depth: return {{"inverse_depth"}, {"confidence", "mask"}};
    case NetworkKind::points: return {{"points"}, {"confidence", "mask", "normals", "metric_scale"}};
    case NetworkKind::depth_and_pose: return {{"depth", "pose"}, {"confidence", "mask"}};
  }
  return {};
}

void read_outputs(const JsonNode& node, DepthManifest& manifest) {
  const Roles roles = roles_of(manifest.kind);
  std::vector<std::string_view> known = roles.needed;
  known.insert(known.end(), roles.possible.begin(), roles.possible.end());
  node.check_keys(known);
  for (const std::string_view role : roles.needed) (void)node[role];  // complains when it is missing
  for (const std::string_view role : node.present(known)) {
    const JsonNode place = node[role];
    OutputPlace& output = manifest.outputs[std::string(role)];
    if (place.value().is_string()) {
      output.key = place.text();
    } else if (place.value().is_number()) {
      output.number = static_cast<int>(place.integer(0, 255));
    } else {
      place.refuse("the output's number in the tuple that forward returns, or its key in the dictionary");
    }
  }
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
  const nlohmann::json json = io::parse_json(io::read_text(path, 1 << 20), path);
  const JsonNode root(json, "", path);
  root.check_keys({"format", "name", "model", "kind", "unit", "input", "outputs", "confidence_rule", "mask_rule",
                   "mask_threshold", "max_depth", "pose_direction", "field_of_view", "window"});
  DepthManifest manifest;
  manifest.path = path;
  (void)root["format"].integer(1, 1);
  if (root.has("name")) manifest.name = root["name"].text();
  if (root.has("model")) manifest.model = root["model"].text();
  if (manifest.model.empty() || manifest.model.find('/') != std::string::npos)
    root["model"].refuse("the name of a file beside the manifest");
  manifest.kind = choice(root["kind"], kinds);
  manifest.input = read_input(root["input"]);
  read_outputs(root["outputs"], manifest);
  read_meanings(root, manifest);
  if (root.has("window")) manifest.window = read_window(root["window"], manifest);
  return manifest;
}

}  // namespace uwv::model
