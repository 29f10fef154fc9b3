// SPDX-License-Identifier: Apache-2.0
#include "model/lora/lora_file.h"

#include <ATen/ATen.h>

#include <optional>
#include <regex>

#include "io/printable.h"
#include "model/weights/wan_names.h"
#include "model/weights/weight_files.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

enum class Part { down, up, alpha, bias, left_out };

struct Key {
  std::string layer;
  Part part;
};

bool cut_end(std::string& text, const std::string& end) {
  if (!text.ends_with(end)) return false;
  text.resize(text.size() - end.size());
  return true;
}

/// Splits a key into the layer's name and what of it the key holds; nothing for a key of no known dialect.
std::optional<Key> split(std::string key) {
  if (cut_end(key, ".diff_b")) return Key{key, key.find("norm") == std::string::npos ? Part::bias : Part::left_out};
  if (cut_end(key, ".diff")) return Key{key, Part::left_out};
  if (cut_end(key, ".alpha")) return Key{key, Part::alpha};
  static const std::regex factor(R"((.*)\.(lora_A|lora_down|lora_B|lora_up)(\.[^.]+)?\.weight)");
  std::smatch match;
  if (!std::regex_match(key, match, factor)) return std::nullopt;
  const std::string kind = match[2];
  return Key{match[1], kind == "lora_A" || kind == "lora_down" ? Part::down : Part::up};
}

/// The diffusers name of a layer in any dialect.
std::string layer_name(const std::string& name) {
  constexpr std::string_view prefix = "transformer.";
  return transformer_diffusers_name(name.starts_with(prefix) ? name.substr(prefix.size()) : name);
}

}  // namespace

LoraFile LoraFile::open(const std::string& path) {
  const WeightFiles weights = WeightFiles::open(path);
  LoraFile lora;
  lora.path_ = path;
  std::map<std::string, double> alphas;
  std::vector<std::string> unknown;
  for (const std::string& name : weights.names()) {
    const auto key = split(name);
    if (!key) {
      unknown.push_back(io::printable(name));
      continue;
    }
    const std::string layer = layer_name(key->layer);
    const auto load = [&] { return weights.load(name, at::kFloat); };
    switch (key->part) {
      case Part::down: lora.layers_[layer].down = load(); break;
      case Part::up: lora.layers_[layer].up = load(); break;
      case Part::bias: lora.layers_[layer].bias = load(); break;
      case Part::alpha: {
        const at::Tensor value = load();
        if (value.numel() != 1)
          fail(ErrorCode::value_invalid, "{}: '{}' holds {} values, wanted one", path, io::printable(name),
               value.numel());
        alphas[layer] = value.item<double>();
        break;
      }
      case Part::left_out: lora.left_out_.push_back(name); break;
    }
  }
  if (!unknown.empty())
    fail(ErrorCode::value_invalid, "{}: {} of its {} keys are of no known LoRA dialect, the first is '{}'", path,
         unknown.size(), weights.names().size(), unknown.front());
  for (auto& [name, layer] : lora.layers_) {
    if (layer.down.defined() != layer.up.defined())
      fail(ErrorCode::value_invalid, "{}: '{}' has only one of its two factors", path, io::printable(name));
    if (!layer.down.defined()) continue;
    if (layer.down.dim() != 2 || layer.up.dim() != 2 || layer.down.size(0) != layer.up.size(1))
      fail(ErrorCode::value_invalid, "{}: the factors of '{}' have no rank in common", path, io::printable(name));
    if (const auto alpha = alphas.find(name); alpha != alphas.end())
      layer.scale = alpha->second / static_cast<double>(layer.down.size(0));
  }
  return lora;
}

}  // namespace uwv::model
