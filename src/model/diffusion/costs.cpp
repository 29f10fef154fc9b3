// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/costs.h"

#include "model/transformer/transformer_cost.h"

namespace uwv::model {
PartCost transformer_cost(const TransformerConfig& config, const PassSize& pass, LinearForm form, bool streamed) {
  TransformerLoad load;
  load.tokens = pass.tokens;
  load.text_tokens = pass.text_tokens;
  load.reference_tokens = pass.reference_tokens;
  load.batch = pass.batch;
  load.form = form;
  load.stored_bytes = static_cast<int>(size_of(pass.stored));
  load.streamed = streamed;
  const auto blocks = static_cast<double>(config.layers) + static_cast<double>(config.vace_layers.size());
  const double floats = 4.0 * config.dim();
  const double keys = 2 * floats * blocks * static_cast<double>(pass.text_tokens);
  // What the last step changed and read, by branch.
  const double cached = pass.step_cache ? 2 * floats * static_cast<double>(pass.tokens) * pass.branches : 0;
  const double beside = keys * (pass.branches - 1) + cached;
  return {estimated_peak_bytes(config, load) + beside, estimated_resting_bytes(config, load) + beside,
          estimated_flops(config, load), estimated_attention_flops(config, load),
          estimated_read_bytes(config, load) / load.stored_bytes};
}

PartCost vae_cost(const VaeConfig& config, const VaeOptions& options, const ClipSize& clip, VaeWay way) {
  return {estimated_peak_bytes(config, clip, options, way), 0, estimated_flops(config, clip, options, way), 0, 0};
}

PartCost tiny_vae_cost(const TinyVaeSizes& sizes, VaePrecision precision, const ClipSize& clip) {
  return {estimated_peak_bytes(sizes, clip, precision), 0, estimated_flops(sizes, clip), 0, 0};
}

}  // namespace uwv::model
