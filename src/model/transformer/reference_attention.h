// SPDX-License-Identifier: Apache-2.0
// What view tokens, or VACE hints, take from the reference video. Sheet model.md, 3 ("RefAttn") and 8 (a).
#pragma once

#include "model/transformer/attention.h"

namespace uwv::model {

class ReferenceAttention {
 public:
  /// Weights are "uniview_ref_attn.<index>.*" and value `index` of "uniview_ref_gates".
  ReferenceAttention(const FusedWeights& weights, int index, int heads, double eps, LinearForm form);

  /// `reference` is (batch or 1, tokens, dim).
  KeysValues keys_values(const at::Tensor& reference) const;
  /// What to add to x, before the gate.
  at::Tensor operator()(const at::Tensor& x, const KeysValues& reference) const;
  /// x += gate * delta.
  void add(const at::Tensor& x, const at::Tensor& delta) const;

 private:
  double eps_;
  at::ScalarType tokens_;
  at::Tensor scale_q_, shift_q_, scale_kv_, shift_kv_, gate_;
  Attention attention_;
};

}  // namespace uwv::model
