// SPDX-License-Identifier: Apache-2.0
// The block that Wan's main stream and its VACE stream are both made of. Sheet model.md, 3 ("Block").
#pragma once

#include "model/transformer/attention.h"
#include "model/transformer/transformer_config.h"

namespace uwv::model {

class TransformerBlock {
 public:
  TransformerBlock(const FusedWeights& weights, const std::string& prefix, const TransformerConfig& config,
                   LinearForm form);

  KeysValues text_keys(const at::Tensor& text) const { return text_attention_.keys_values(text); }

  /// Changes x (batch, tokens, dim; float32) in place. `time` is (batch, 6, dim). At most `ffn_rows` tokens go through
  /// the feed-forward layer at once, which is several times as wide as a token.
  void operator()(const at::Tensor& x, const at::Tensor& time, const KeysValues& text, const RotaryTables& rotary,
                  std::int64_t ffn_rows) const;

  /// What the self-attention would read: x normed and modulated by the time.
  at::Tensor modulated(const at::Tensor& x, const at::Tensor& time) const;

 private:
  at::Tensor feed_forward(const at::Tensor& x, std::int64_t rows) const;

  double eps_;
  at::ScalarType tokens_;
  at::Tensor table_, norm_scale_, norm_shift_;
  Attention self_attention_, text_attention_;
  Linear widen_, narrow_;
};

}  // namespace uwv::model
