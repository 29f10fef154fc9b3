// SPDX-License-Identifier: Apache-2.0
#include "model/transformer/block.h"

#include <ATen/ATen.h>

#include "model/layers/token_kernels.h"
#include "model/transformer/weight_access.h"

namespace uwv::model {
namespace {

/// Where the parts of a block's modulation lie.
enum Part { shift_self, scale_self, gate_self, shift_ffn, scale_ffn, gate_ffn };

}  // namespace

TransformerBlock::TransformerBlock(const FusedWeights& weights, const std::string& prefix,
                                   const TransformerConfig& config, LinearForm form)
    : eps_(config.eps),
      tokens_(token_type(form)),
      table_(as_float(weights, prefix + ".scale_shift_table")),
      self_attention_(weights, prefix + ".attn1", config.heads, config.eps, form),
      text_attention_(weights, prefix + ".attn2", config.heads, config.eps, form),
      widen_(linear(weights, prefix + ".ffn.net.0.proj", form)),
      narrow_(linear(weights, prefix + ".ffn.net.2", form)) {
  if (!config.cross_attn_norm) return;
  norm_scale_ = as_float(weights, prefix + ".norm2.weight");
  norm_shift_ = as_float(weights, prefix + ".norm2.bias");
}

at::Tensor TransformerBlock::modulated(const at::Tensor& x, const at::Tensor& time) const {
  const at::Tensor parts = table_ + time;
  return layer_norm(x, parts.select(1, scale_self) + 1, parts.select(1, shift_self), eps_, tokens_);
}

void TransformerBlock::operator()(const at::Tensor& x, const at::Tensor& time, const KeysValues& text,
                                  const RotaryTables& rotary, std::int64_t ffn_rows) const {
  const at::Tensor parts = table_ + time;
  add_gated(x, self_attention_(modulated(x, time), rotary), parts.select(1, gate_self));
  add_gated(x,
            text_attention_(
                norm_scale_.defined() ? layer_norm(x, norm_scale_, norm_shift_, eps_, tokens_) : x.to(tokens_), text),
            {});
  const at::Tensor normed = layer_norm(x, parts.select(1, scale_ffn) + 1, parts.select(1, shift_ffn), eps_, tokens_);
  add_gated(x, feed_forward(normed, ffn_rows), parts.select(1, gate_ffn));
}

at::Tensor TransformerBlock::feed_forward(const at::Tensor& x, std::int64_t rows) const {
  const at::Tensor flat = x.flatten(0, 1);
  const auto some = [&](const at::Tensor& part) {
    at::Tensor wide = widen_(part);
    return narrow_(at::gelu_(wide, "tanh"));
  };
  if (flat.size(0) <= rows) return some(flat).view(x.sizes());
  at::Tensor result = at::empty_like(x);
  for (std::int64_t begin = 0; begin < flat.size(0); begin += rows) {
    const std::int64_t end = std::min(begin + rows, flat.size(0));
    result.flatten(0, 1).slice(0, begin, end).copy_(some(flat.slice(0, begin, end)));
  }
  return result;
}

}  // namespace uwv::model
