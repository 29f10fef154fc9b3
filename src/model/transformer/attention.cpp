// SPDX-License-Identifier: Apache-2.0
#include "model/transformer/attention.h"

#include <ATen/ATen.h>

#include "model/layers/token_kernels.h"
#include "model/transformer/weight_access.h"

namespace uwv::model {

Attention::Attention(const FusedWeights& weights, const std::string& prefix, int heads, double eps, LinearForm form)
    : heads_(heads),
      eps_(eps),
      to_q_(linear(weights, prefix + ".to_q", form)),
      to_k_(linear(weights, prefix + ".to_k", form)),
      to_v_(linear(weights, prefix + ".to_v", form)),
      to_out_(linear(weights, prefix + ".to_out.0", form)),
      norm_q_(as_float(weights, prefix + ".norm_q.weight")),
      norm_k_(as_float(weights, prefix + ".norm_k.weight")) {}

at::Tensor Attention::attend(const at::Tensor& queries, const KeysValues& other) const {
  const std::int64_t batch = queries.size(0);
  const auto by_head = [&](const at::Tensor& x) {
    return x.expand({batch, x.size(1), x.size(2)}).unflatten(2, {heads_, -1}).transpose(1, 2);
  };
  const at::Tensor mixed =
      at::scaled_dot_product_attention(by_head(queries), by_head(other.keys), by_head(other.values));
  return to_out_(mixed.transpose(1, 2).flatten(2));
}

at::Tensor Attention::operator()(const at::Tensor& x, const RotaryTables& rotary) const {
  at::Tensor queries;
  KeysValues own;
  {
    const LinearInput input = to_q_.prepare(x);
    queries = to_q_(input).view(x.sizes());
    own = {to_k_(input).view(x.sizes()), to_v_(input).view(x.sizes())};
  }
  rms_norm_rotate(queries, norm_q_, eps_, rotary.cosine, rotary.sine);
  rms_norm_rotate(own.keys, norm_k_, eps_, rotary.cosine, rotary.sine);
  return attend(queries, own);
}

KeysValues Attention::keys_values(const at::Tensor& tokens) const {
  const LinearInput input = to_k_.prepare(tokens);
  KeysValues other{to_k_(input).view(tokens.sizes()), to_v_(input).view(tokens.sizes())};
  rms_norm_rotate(other.keys, norm_k_, eps_, {}, {});
  return other;
}

at::Tensor Attention::operator()(const at::Tensor& x, const KeysValues& other) const {
  at::Tensor queries = to_q_(x);
  rms_norm_rotate(queries, norm_q_, eps_, {}, {});
  return attend(queries, other);
}

}  // namespace uwv::model
