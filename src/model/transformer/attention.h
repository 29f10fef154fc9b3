// SPDX-License-Identifier: Apache-2.0
// Attention with norms over all heads' queries and keys together, as everywhere in Wan. Sheet model.md, 3
// ("Attention").
#pragma once

#include "model/layers/linear.h"
#include "model/lora/fused_weights.h"
#include "model/transformer/rotary.h"

namespace uwv::model {

/// What is attended to: (batch, tokens, dim) each, normed, not split into heads.
struct KeysValues {
  at::Tensor keys, values;
  bool defined() const { return keys.defined(); }
};

class Attention {
 public:
  /// Weights are prefix + ".to_q.weight" and so on.
  Attention(const FusedWeights& weights, const std::string& prefix, int heads, double eps, LinearForm form);

  /// To the tokens themselves, with rotary positions. x is (batch, tokens, dim); so is the answer.
  at::Tensor operator()(const at::Tensor& x, const RotaryTables& rotary) const;

  /// To other tokens (batch or 1, any number, dim), without positions.
  KeysValues keys_values(const at::Tensor& tokens) const;
  at::Tensor operator()(const at::Tensor& x, const KeysValues& other) const;

 private:
  at::Tensor attend(const at::Tensor& queries, const KeysValues& other) const;

  int heads_;
  double eps_;
  Linear to_q_, to_k_, to_v_, to_out_;
  at::Tensor norm_q_, norm_k_;
};

}  // namespace uwv::model
