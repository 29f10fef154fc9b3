// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/rungs.h"

#include <algorithm>

namespace uwv::model {
namespace {

LinearForm linear_form_of(WeightsForm weights) {
  switch (weights) {
    case WeightsForm::bf16_stored: return LinearForm::bf16_stored;
    case WeightsForm::bf16: return LinearForm::bf16;
    case WeightsForm::int8_stored: return LinearForm::int8_stored;
    case WeightsForm::int8: return LinearForm::int8;
    default: return LinearForm::f32;
  }
}

VaePrecision vae_precision_of(VaeNumbers numbers) {
  switch (numbers) {
    case VaeNumbers::f32: return VaePrecision::f32;
    case VaeNumbers::bf16: return VaePrecision::bf16;
    default: return VaePrecision::automatic;
  }
}

}  // namespace

Rungs choose_rungs(const ModelOptions& options, const TransformerConfig&) {
  Rungs rungs;
  rungs.form = linear_form_of(options.weights);
  rungs.streamed = options.stream.value_or(false);
  rungs.vae = {vae_precision_of(options.vae_precision), std::max(1, options.vae_bands)};
  return rungs;
}

}  // namespace uwv::model
