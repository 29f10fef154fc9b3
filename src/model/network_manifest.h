// SPDX-License-Identifier: Apache-2.0
// What the manifests of all networks share: where the TorchScript file is, how pictures go in, which output is which.
// docs/depth-models.md is their reference.
#pragma once

#include <array>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/script_module.h"
#include "trajectory/json_node.h"
#include "uwv/core/image.h"

namespace uwv::model {

enum class SizeRule { fixed, shorter_side, longer_side, width, area };
enum class Rounding { nearest, down, up };
enum class InputFilter { bilinear, bicubic, area, lanczos };

struct InputRule {
  SizeRule size_rule = SizeRule::longer_side;
  int side = 0;         ///< For shorter_side, longer_side, width.
  Size size;            ///< For fixed.
  double pixels = 0;    ///< For area.
  int multiple_of = 1;  ///< Both sides become multiples of it.
  Rounding rounding = Rounding::nearest;
  double limit_aspect = 0;  ///< For shorter_side: pictures longer than this get a smaller side; 0 = no limit.
  InputFilter filter = InputFilter::bicubic;
  bool bgr = false;
  std::array<double, 2> range{0, 1};  ///< What 0 and 255 become, before mean and std.
  std::array<double, 3> mean{0, 0, 0}, std{1, 1, 1};
  std::string layout = "NCHW";  ///< Letters N (1), T (frames), C, H, W.
  TensorType dtype = TensorType::float32;

  bool takes_clips() const { return layout.find('T') != std::string::npos; }
};

/// Which of forward's outputs something is: its place in the tuple, or its key in the dictionary.
struct OutputPlace {
  int number = -1;
  std::string key;
};

struct NetworkManifest {
  std::string path;
  std::string name;
  std::string model = "model.ts";
  InputRule input;
  std::map<std::string, OutputPlace, std::less<>> outputs;
};

/// The outputs a kind of network must have, then those it may have.
struct Roles {
  std::vector<std::string_view> needed, possible;
};

/// One of several words.
template <class Enum, std::size_t N>
Enum choice(const detail::JsonNode& node, const std::array<std::pair<std::string_view, Enum>, N>& choices) {
  std::vector<std::string_view> names;
  for (const auto& [name, value] : choices) names.push_back(name);
  const std::string text = node.text(names);
  for (const auto& [name, value] : choices)
    if (name == text) return value;
  return choices.front().second;  // not reached: text() refuses other words
}

/// How a mask output is to be read.
inline constexpr std::array<std::pair<std::string_view, bool>, 2> mask_rules{{{"probability", false}, {"logit", true}}};

/// The keys format, name and model. Throws Error(value_invalid).
void read_shared_keys(const detail::JsonNode& root, NetworkManifest& manifest);
/// The key input. Throws Error(value_invalid).
InputRule read_input(const detail::JsonNode& node);
/// The key outputs. Throws Error(value_invalid).
void read_outputs(const detail::JsonNode& node, const Roles& roles, NetworkManifest& manifest);

/// The path of a folder's manifest.json; `what` names the kind of network. Throws Error(file_not_found).
std::string manifest_in(const std::string& folder, std::string_view what);
/// The manifest's JSON. Throws Error(file_not_found, file_damaged, value_invalid).
nlohmann::json read_manifest_json(const std::string& path);
/// Where the network is; the manifest gets its folder's name if it has none. Throws Error(file_not_found).
std::string locate_model(const std::string& folder, NetworkManifest& manifest);

}  // namespace uwv::model
