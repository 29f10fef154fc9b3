// SPDX-License-Identifier: Apache-2.0
// Short words for what every part of the transformer takes from its weights.
#pragma once

#include <string>

#include "model/layers/linear.h"
#include "model/lora/fused_weights.h"

namespace uwv::model {

/// prefix + ".weight" and ".bias".
inline Linear linear(const FusedWeights& weights, const std::string& prefix, LinearForm form) {
  const std::string weight = prefix + ".weight";
  const at::Tensor bias = weights.tensor(prefix + ".bias");
  if (weights.stays_quantised(weight)) return {weights.files().quantised(weight), bias, form};
  return {weights.tensor(weight), bias, form};
}

/// Of the small ones; a copy, so that the file's pages around them need not stay in memory.
inline at::Tensor as_float(const FusedWeights& weights, const std::string& name) {
  return weights.tensor(name).to(at::kFloat, /*non_blocking=*/false, /*copy=*/true);
}

}  // namespace uwv::model
