// SPDX-License-Identifier: Apache-2.0
#include "model/layers/linear.h"

#include <ATen/ATen.h>

namespace uwv::model {

Linear::Linear(const at::Tensor& weight, const at::Tensor& bias, LinearForm form) : form_(form) {
  weight_ = weight.to(form == LinearForm::f32 ? at::kFloat : at::kBFloat16);
  if (bias.defined()) bias_ = bias.to(form == LinearForm::bf16 ? at::kBFloat16 : at::kFloat);
}

Linear::Linear(const WeightFiles& weights, const std::string& prefix, LinearForm form)
    : Linear(weights.view(prefix + ".weight"),
             weights.has(prefix + ".bias") ? weights.view(prefix + ".bias") : at::Tensor(), form) {}

at::Tensor Linear::operator()(const at::Tensor& x) const {
  const at::ScalarType type = form_ == LinearForm::bf16 ? at::kBFloat16 : at::kFloat;
  return at::linear(x.to(type), weight_.to(type), bias_).to(x.scalar_type());
}

}  // namespace uwv::model
