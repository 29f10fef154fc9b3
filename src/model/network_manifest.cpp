// SPDX-License-Identifier: Apache-2.0
#include "model/network_manifest.h"

#include <algorithm>
#include <filesystem>

#include "io/disk_file.h"
#include "io/json_text.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

using detail::JsonNode;

constexpr long largest_side = 16384;

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

}  // namespace

void read_shared_keys(const JsonNode& root, NetworkManifest& manifest) {
  (void)root["format"].integer(1, 1);
  if (root.has("name")) manifest.name = root["name"].text();
  if (root.has("model")) manifest.model = root["model"].text();
  if (manifest.model.empty() || manifest.model.find('/') != std::string::npos)
    root["model"].refuse("the name of a file beside the manifest");
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

void read_outputs(const JsonNode& node, const Roles& roles, NetworkManifest& manifest) {
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

std::string manifest_in(const std::string& folder, std::string_view what) {
  const std::filesystem::path path(folder);
  std::error_code ignored;
  if (!std::filesystem::is_directory(path, ignored))
    fail(ErrorCode::file_not_found, "{}: is no folder; {} is a folder with manifest.json and a TorchScript file",
         folder, what);
  const std::string manifest = (path / "manifest.json").string();
  if (!std::filesystem::exists(manifest, ignored))
    fail(ErrorCode::file_not_found,
         "{}: is missing; it says what goes into the network and what comes out, see docs/depth-models.md", manifest);
  return manifest;
}

nlohmann::json read_manifest_json(const std::string& path) {
  constexpr std::uint64_t max_bytes = 1 << 20;
  return io::parse_json(io::read_text(path, max_bytes), path);
}

std::string locate_model(const std::string& folder, NetworkManifest& manifest) {
  const std::filesystem::path path(folder);
  std::error_code ignored;
  if (manifest.name.empty()) manifest.name = std::filesystem::absolute(path).lexically_normal().filename().string();
  const std::string model_path = (path / manifest.model).string();
  if (!std::filesystem::exists(model_path, ignored))
    fail(ErrorCode::file_not_found, "{}: is missing; put the exported network there or change 'model' in {}",
         model_path, manifest.path);
  return model_path;
}

}  // namespace uwv::model
