// SPDX-License-Identifier: Apache-2.0
#include "model/transformer/wan_network.h"

#include <ATen/ATen.h>

#include "io/printable.h"
#include "model/transformer/transformer_shapes.h"
#include "model/transformer/weight_access.h"
#include "model/weights/wan_names.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

constexpr std::size_t names_told = 5;

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), names_told); ++i)
    text += (i == 0 ? "" : ", ") + io::printable(names[i]);
  return names.size() > names_told ? fmt::format("{} and {} more", text, names.size() - names_told) : text;
}

/// The folder's weights under diffusers' names, whoever wrote them.
WeightFiles weights_in(const std::string& folder, c10::Device device) {
  WeightFiles weights = WeightFiles::open(folder);
  weights.put_on(device);
  weights.rename(transformer_diffusers_name);
  return weights;
}

bool holds_any(const WeightFiles& files, const std::string& start) {
  for (const std::string& name : files.names())
    if (name.starts_with(start)) return true;
  return false;
}

}  // namespace

WanTransformer::Network::Network(const std::string& folder, TransformerOptions options)
    : options_(std::move(options)),
      config_(TransformerConfig::read(folder)),
      weights_(weights_in(folder, options_.device)) {
  settle_reference_branch();
  check_weights();
  set_loras(std::move(options_.loras));
}

/// Stage-1 checkpoints lack the reference branch though their config speaks of it. Sheet model.md, 1 ("Checkpoint").
void WanTransformer::Network::settle_reference_branch() {
  if (config_.reference == ReferenceBranch::none) return;
  if (holds_any(weights_.files(), "uniview_ref_attn.")) return;
  config_.reference = ReferenceBranch::none;
  config_.ref_at.clear();
  warnings_.push_back(weights_.files().path() +
                      ": holds no uniview_ref_attn.*, so the reference video is not looked at (a stage-1 checkpoint)");
}

void WanTransformer::Network::check_weights() {
  TensorShapes wanted = transformer_shapes(config_);
  const std::string lent = "ref_patch_embedding", lender = "patch_embedding";
  if (config_.reference != ReferenceBranch::none && !holds_any(weights_.files(), lent + ".")) {
    require(config_.ref_in_channels == config_.in_channels,
            "uniview_ref_in_channels is {} and in_channels {}: {} cannot stand in for the missing {}",
            config_.ref_in_channels, config_.in_channels, lender, lent);
    wanted.erase(lent + ".weight");
    wanted.erase(lent + ".bias");
    warnings_.push_back(weights_.files().path() + ": holds no " + lent + "; " + lender + " is taken for it");
  }
  if (const std::vector<std::string> extra = weights_.files().check(wanted); !extra.empty())
    warnings_.push_back(
        fmt::format("{}: {} tensors are not used: {}", weights_.files().path(), extra.size(), listed(extra)));
}

void WanTransformer::Network::set_loras(std::vector<WeightedLora> loras) {
  weights_.set_changes(loras);
  options_.loras = std::move(loras);
  stages_.reset();
  ends_ = std::make_unique<Ends>(weights_, config_);
  stages_ = std::make_unique<Stages>(weights_, config_, options_.form, options_.streamed);
}

WanTransformer::Network::Ends::Ends(const FusedWeights& weights, const TransformerConfig& config)
    : patches(weights, "patch_embedding"),
      time(weights, config.freq_dim),
      text(weights),
      out_table(as_float(weights, "scale_shift_table")),
      out(linear(weights, "proj_out", LinearForm::f32)) {
  if (!config.vace_layers.empty()) control_patches.emplace(weights, "vace_patch_embedding");
  if (config.reference != ReferenceBranch::none)
    reference_patches.emplace(weights,
                              weights.has("ref_patch_embedding.weight") ? "ref_patch_embedding" : "patch_embedding");
}

}  // namespace uwv::model
