// SPDX-License-Identifier: Apache-2.0
#include "model/vae/vae_blocks.h"

#include <ATen/ATen.h>

namespace uwv::model {
namespace {

/// What the next convolution reads: the frame, normed and through SiLU, as the newest of its history.
void remember(const RmsNorm& norm, const at::Tensor& frame, FrameHistory& history, FramePool& pool) {
  at::Tensor newest = pool.take(frame.size(0), frame.size(1), frame.size(2));
  norm.with_silu(frame, newest);
  history.push(std::move(newest));
}

}  // namespace

ResBlock::ResBlock(const WeightFiles& weights, const std::string& prefix, const VaeArithmetic& how)
    : norm1_(weights, prefix + ".norm1"),
      norm2_(weights, prefix + ".norm2"),
      conv1_(weights, prefix + ".conv1", how),
      conv2_(weights, prefix + ".conv2", how) {
  if (weights.has(prefix + ".conv_shortcut.weight")) shortcut_.emplace(weights, prefix + ".conv_shortcut", how);
}

at::Tensor ResBlock::operator()(at::Tensor frame, Memory& memory, VaePass& pass) const {
  pass.between();
  remember(norm1_, frame, memory.first, pass.pool);
  at::Tensor inner = conv1_(memory.first, pass.pool);
  remember(norm2_, inner, memory.second, pass.pool);
  inner.reset();
  pass.between();
  at::Tensor sum = shortcut_ ? (*shortcut_)(frame) : std::move(frame);
  conv2_.add_to(sum, memory.second, pass.pool);
  return sum;
}

FrameAttention::FrameAttention(const WeightFiles& weights, const std::string& prefix, const VaeArithmetic& how)
    : norm_(weights, prefix + ".norm"),
      to_qkv_(weights, prefix + ".to_qkv", how),
      proj_(weights, prefix + ".proj", how) {}

at::Tensor FrameAttention::operator()(at::Tensor frame, VaePass& pass) const {
  pass.between();
  const std::int64_t channels = frame.size(2);
  at::Tensor normed = pass.pool.take(frame.size(0), frame.size(1), channels);
  norm_(frame, normed);
  const std::vector<at::Tensor> qkv = to_qkv_(normed).reshape({1, 1, -1, 3 * channels}).chunk(3, -1);
  pass.pool.give(std::move(normed));
  const at::Tensor seen = at::scaled_dot_product_attention(qkv[0], qkv[1], qkv[2]);
  return frame.add_(proj_(seen).view_as(frame));
}

MidBlock::MidBlock(const WeightFiles& weights, const std::string& prefix, const VaeArithmetic& how)
    : first_(weights, prefix + ".resnets.0", how),
      attention_(weights, prefix + ".attentions.0", how),
      second_(weights, prefix + ".resnets.1", how) {}

at::Tensor MidBlock::operator()(at::Tensor frame, Memory& memory, VaePass& pass) const {
  frame = first_(std::move(frame), memory.first, pass);
  frame = attention_(std::move(frame), pass);
  return second_(std::move(frame), memory.second, pass);
}

VaeHead::VaeHead(const WeightFiles& weights, const std::string& prefix, const VaeArithmetic& how)
    : norm_(weights, prefix + ".norm_out"), conv_(weights, prefix + ".conv_out", how) {}

at::Tensor VaeHead::operator()(const at::Tensor& frame, FrameHistory& memory, VaePass& pass) const {
  remember(norm_, frame, memory, pass.pool);
  return conv_(memory, pass.pool);
}

}  // namespace uwv::model
