// SPDX-License-Identifier: Apache-2.0
#include "model/transformer/wan_transformer.h"

#include <ATen/ATen.h>

#include "model/transformer/forward_pass.h"
#include "model/transformer/wan_network.h"
#include "uwv/core/error.h"

namespace uwv::model {

void TransformerOptions::check() const { require(ffn_rows > 0, "ffn_rows is {}, wanted at least 1", ffn_rows); }

WanTransformer::WanTransformer(std::unique_ptr<Network> network) : network_(std::move(network)) {}
WanTransformer::WanTransformer(WanTransformer&&) noexcept = default;
WanTransformer& WanTransformer::operator=(WanTransformer&&) noexcept = default;
WanTransformer::~WanTransformer() = default;

WanTransformer WanTransformer::open(const std::string& folder, const TransformerOptions& options) {
  options.check();
  return WanTransformer(std::make_unique<Network>(folder, options));
}

const TransformerConfig& WanTransformer::config() const { return network_->config(); }

const std::vector<std::string>& WanTransformer::warnings() const { return network_->warnings(); }

void WanTransformer::set_loras(std::vector<WeightedLora> loras) { network_->set_loras(std::move(loras)); }

TransformerContext WanTransformer::prepare(const at::Tensor& control, const at::Tensor& ref_latents,
                                           const at::Tensor& text, const at::Tensor& control_scale) const {
  const TransformerConfig& c = config();
  const c10::Device device = network_->options().device;
  const auto hints = static_cast<std::int64_t>(c.vace_layers.size());
  require(control.defined() == (hints > 0), "the model has {} VACE blocks, and control latents are {}", hints,
          control.defined() ? "given" : "missing");
  require(!control_scale.defined() || control_scale.numel() == hints, "{} control scales are given for {} VACE blocks",
          control_scale.defined() ? control_scale.numel() : 0, hints);
  TransformerContext context;
  if (control.defined()) context.control = (*network_->ends().control_patches)(control.to(device));
  if (ref_latents.defined() && network_->ends().reference_patches)
    context.reference = (*network_->ends().reference_patches)(ref_latents.to(device));
  context.control_scale = (control_scale.defined() ? control_scale.to(at::kFloat) : at::ones({hints})).to(device);
  context.reference_keys.resize(network_->stages().order().size());
  return with_text(context, text);
}

TransformerContext WanTransformer::with_text(const TransformerContext& context, const at::Tensor& text) const {
  require(text.dim() == 3 && text.size(2) == config().text_dim && text.size(1) > 0,
          "text has {} dimensions, the last of {}, wanted (batch, tokens, {})", text.dim(),
          text.dim() > 0 ? text.size(-1) : 0, config().text_dim);
  TransformerContext other = context;
  other.text = network_->ends().text(text.to(network_->options().device));
  other.text_keys.assign(network_->stages().order().size(), {});
  other.change = at::Tensor();
  return other;
}

at::Tensor WanTransformer::forward(TransformerContext& context, const at::Tensor& latents, const at::Tensor& timestep,
                                   const TransformerHooks& hooks) const {
  const c10::Device device = network_->options().device;
  if (context.kept.defined()) context.kept = context.kept.to(device);
  return ForwardPass(*network_, context, hooks).run(latents.to(device), timestep.to(device));
}

}  // namespace uwv::model
