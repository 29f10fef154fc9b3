// SPDX-License-Identifier: Apache-2.0
#include "model/lora/fused_weights.h"

#include <ATen/ATen.h>

#include <algorithm>

#include "model/float_tensor.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

const std::string weight_end = ".weight", bias_end = ".bias";

/// What does not fit between one layer's change and the checkpoint; empty when all does.
std::string misfit(const WeightFiles& files, const std::string& name, const LoraLayer& layer) {
  if (layer.down.defined()) {
    if (!files.has(name + weight_end)) return name + weight_end + " is not in the checkpoint";
    const auto shape = files.shape(name + weight_end);
    if (shape.size() != 2 || shape[0] != layer.up.size(0) || shape[1] != layer.down.size(1))
      return fmt::format("{}{} would need {} but is {}", name, weight_end,
                         shape_text({layer.up.size(0), layer.down.size(1)}), shape_text(shape));
  }
  if (layer.bias.defined()) {
    if (!files.has(name + bias_end)) return name + bias_end + " is not in the checkpoint";
    if (files.shape(name + bias_end) != layer.bias.sizes().vec())
      return fmt::format("{}{} has other than {} values", name, bias_end, layer.bias.numel());
  }
  return "";
}

}  // namespace

void FusedWeights::set_changes(std::vector<WeightedLora> changes) {
  for (const WeightedLora& change : changes) {
    std::vector<std::string> misfits;
    for (const auto& [name, layer] : change.file.layers())
      if (std::string complaint = misfit(files_, name, layer); !complaint.empty())
        misfits.push_back(std::move(complaint));
    if (!misfits.empty())
      fail(ErrorCode::value_invalid, "{}: {} of its {} layers do not fit {} (the first: {}); use a LoRA of this model",
           change.file.path(), misfits.size(), change.file.layers().size(), files_.path(), misfits.front());
  }
  changes_ = std::move(changes);
}

bool FusedWeights::is_changed(const std::string& name) const {
  if (!name.ends_with(weight_end)) return false;
  const std::string layer = name.substr(0, name.size() - weight_end.size());
  return std::any_of(changes_.begin(), changes_.end(), [&](const WeightedLora& change) {
    const auto found = change.file.layers().find(layer);
    return found != change.file.layers().end() && found->second.down.defined();
  });
}

bool FusedWeights::stays_quantised(const std::string& name) const {
  return files_.is_quantised(name) && !is_changed(name);
}

at::Tensor FusedWeights::tensor(const std::string& name) const {
  const bool is_bias = name.ends_with(bias_end);
  const std::string layer_name = name.substr(0, name.rfind('.') == std::string::npos ? name.size() : name.rfind('.'));
  const bool widened = files_.is_quantised(name) && is_changed(name);
  at::Tensor result;
  if (widened) {
    const QuantisedWeight weight = files_.quantised(name);
    result = weight.numbers.to(at::kFloat).mul_(weight.scales.unsqueeze(1));
  } else {
    result = files_.view(name);
  }
  bool changed = widened;
  for (const WeightedLora& change : changes_) {
    const auto found = change.file.layers().find(layer_name);
    if (found == change.file.layers().end()) continue;
    const LoraLayer& layer = found->second;
    const bool concerns = is_bias ? layer.bias.defined() : name.ends_with(weight_end) && layer.down.defined();
    if (!concerns) continue;
    if (!changed) result = result.to(at::kFloat, /*non_blocking=*/false, /*copy=*/true);
    changed = true;
    if (is_bias)
      result.add_(layer.bias.to(result.device()), change.weight);
    else
      result.addmm_(layer.up.to(result.device()), layer.down.to(result.device()), 1, change.weight * layer.scale);
  }
  return result;
}

}  // namespace uwv::model
