// SPDX-License-Identifier: Apache-2.0
#include "model/transformer/reference_attention.h"

#include <ATen/ATen.h>

#include "model/layers/token_kernels.h"
#include "model/transformer/weight_access.h"

namespace uwv::model {
namespace {

std::string name_of(int index) { return "uniview_ref_attn." + std::to_string(index); }

}  // namespace

ReferenceAttention::ReferenceAttention(const FusedWeights& weights, int index, int heads, double eps, LinearForm form)
    : eps_(eps),
      tokens_(token_type(form)),
      scale_q_(as_float(weights, name_of(index) + ".norm_q.weight")),
      shift_q_(as_float(weights, name_of(index) + ".norm_q.bias")),
      scale_kv_(as_float(weights, name_of(index) + ".norm_kv.weight")),
      shift_kv_(as_float(weights, name_of(index) + ".norm_kv.bias")),
      gate_(as_float(weights, "uniview_ref_gates")[index].expand_as(scale_q_).contiguous()),
      attention_(weights, name_of(index) + ".attn", heads, eps, form) {}

KeysValues ReferenceAttention::keys_values(const at::Tensor& reference) const {
  return attention_.keys_values(layer_norm(reference, scale_kv_, shift_kv_, eps_, tokens_));
}

at::Tensor ReferenceAttention::operator()(const at::Tensor& x, const KeysValues& reference) const {
  return attention_(layer_norm(x, scale_q_, shift_q_, eps_, tokens_), reference);
}

void ReferenceAttention::add(const at::Tensor& x, const at::Tensor& delta) const { add_gated(x, delta, gate_); }

}  // namespace uwv::model
