// SPDX-License-Identifier: Apache-2.0
// What the parts of the model need, reckoned from their settings alone.
#pragma once

#include <cstdint>

#include "model/layers/linear_form.h"
#include "model/transformer/transformer_config.h"
#include "model/vae/tiny_vae_cost.h"
#include "model/vae/vae_cost.h"
#include "uwv/io/dtype.h"

namespace uwv::model {

struct PartCost {
  double bytes = 0;    ///< Resident at the largest, weights included.
  double resting = 0;  ///< Of these, what stays between passes; of the transformer only.
  double flops = 0;
  double attention_flops = 0;  ///< Of these, where attention is counted apart.
  double rounded = 0;          ///< Weights that are rounded to another form in each pass.
};

/// What one pass of the transformer goes over.
struct PassSize {
  std::int64_t tokens = 0, text_tokens = 512, reference_tokens = 0;
  int batch = 1;
  DType stored = DType::bf16;  ///< Of most numbers in the checkpoint.
  int branches = 2;            ///< Whose keys are kept from step to step.
  bool step_cache = false;
};

PartCost transformer_cost(const TransformerConfig& config, const PassSize& pass, LinearForm form, bool streamed);

/// The caller's frames and latents not included.
PartCost vae_cost(const VaeConfig& config, const VaeOptions& options, const ClipSize& clip, VaeWay way);

/// Likewise, of the tiny decoder.
PartCost tiny_vae_cost(const TinyVaeSizes& sizes, VaePrecision precision, const ClipSize& clip);

}  // namespace uwv::model
