// SPDX-License-Identifier: Apache-2.0
#include "model/vae/vae_blocks.h"

#include <ATen/ATen.h>

namespace uwv::model {
namespace {

/// What the next convolution reads: the frame, normed and through SiLU, as the newest of its history.
void remember(const RmsNorm& norm, const at::Tensor& frame, ConvMemory& memory, VaePass& pass) {
  BorderedFrame newest =
      bordered_frame(pass.pool, pass.place, memory.step, frame.size(0), frame.size(1), frame.size(2));
  norm.with_silu(frame, newest.inside);
  memory.frames.push(std::move(newest.frame));
}

/// The convolution of what `all` has at hand, normed.
at::Tensor convolved(const RmsNorm& norm, const CausalConv& conv, const at::Tensor& all, ConvMemory& memory,
                     VaePass& pass) {
  const BandStep& step = memory.step;
  if (step.made.count() == 0) return no_rows(all, all.size(1), conv.results());
  remember(norm, rows_of(all, step.all.begin, step.read), memory, pass);
  return conv(memory.frames, pass.pool, pass.row_edge());
}

}  // namespace

void VaePass::enter(const BandPlace& band) {
  pool = FramePool(pool.type(), pool.device());
  place = band;
}

at::Tensor VaePass::joined(const at::Tensor& fresh, ConvMemory& memory) const {
  return memory.seam.join(fresh, memory.step, place, pool, seams);
}

BorderedFrame bordered_frame(const FramePool& pool, const BandPlace& place, const BandStep& step, std::int64_t rows,
                             std::int64_t width, std::int64_t channels) {
  const std::int64_t above = !place.whole() && step.at_top ? 1 : 0, below = !place.whole() && step.at_bottom ? 1 : 0;
  at::Tensor frame = pool.take(above + rows + below, width, channels);
  if (above > 0) frame.narrow(0, 0, 1).zero_();
  if (below > 0) frame.narrow(0, above + rows, 1).zero_();
  return {frame, frame.narrow(0, above, rows)};
}

at::Tensor no_rows(const at::Tensor& like, std::int64_t width, std::int64_t channels) {
  return at::empty({0, width, channels}, like.options());
}

void ResBlock::Memory::enter(std::int64_t height, BandLines& lines) {
  const BlockStep step = block_step(height, lines);
  first.enter(step.first);
  second.enter(step.second);
}

ResBlock::ResBlock(const WeightFiles& weights, const std::string& prefix, const VaeArithmetic& how)
    : norm1_(weights, prefix + ".norm1"),
      norm2_(weights, prefix + ".norm2"),
      conv1_(weights, prefix + ".conv1", how),
      conv2_(weights, prefix + ".conv2", how) {
  if (weights.has(prefix + ".conv_shortcut.weight")) shortcut_.emplace(weights, prefix + ".conv_shortcut", how);
}

at::Tensor ResBlock::operator()(at::Tensor frame, Memory& memory, VaePass& pass) const {
  pass.between();
  const at::Tensor all = pass.joined(frame, memory.first);
  frame.reset();
  at::Tensor inner = convolved(norm1_, conv1_, all, memory.first, pass);
  inner = pass.joined(inner, memory.second);
  const BandStep& step = memory.second.step;
  if (step.made.count() == 0) return no_rows(all, all.size(1), conv2_.results());
  remember(norm2_, rows_of(inner, step.all.begin, step.read), memory.second, pass);
  inner.reset();
  pass.between();
  at::Tensor sum = rows_of(all, memory.first.step.all.begin, step.made);
  if (shortcut_) sum = (*shortcut_)(sum);
  conv2_.add_to(sum, memory.second.frames, pass.pool, pass.row_edge());
  return sum;
}

FrameAttention::FrameAttention(const WeightFiles& weights, const std::string& prefix, const VaeArithmetic& how)
    : norm_(weights, prefix + ".norm"),
      to_qkv_(weights, prefix + ".to_qkv", how),
      proj_(weights, prefix + ".proj", how) {}

void FrameAttention::operator()(at::Tensor& frame, VaePass& pass) const {
  pass.between();
  const std::int64_t channels = frame.size(2);
  at::Tensor normed = pass.pool.take(frame.size(0), frame.size(1), channels);
  norm_(frame, normed);
  const std::vector<at::Tensor> qkv = to_qkv_(normed).reshape({1, 1, -1, 3 * channels}).chunk(3, -1);
  normed.reset();
  const at::Tensor seen = at::scaled_dot_product_attention(qkv[0], qkv[1], qkv[2]);
  frame.add_(proj_(seen).view_as(frame));
}

void MidBlock::Memory::enter(std::int64_t height) {
  BandLines lines{{0, height + 4}};  // As many convolutions, so that all make all rows.
  first.enter(height, lines);
  second.enter(height, lines);
}

MidBlock::MidBlock(const WeightFiles& weights, const std::string& prefix, const VaeArithmetic& how)
    : first_(weights, prefix + ".resnets.0", how),
      attention_(weights, prefix + ".attentions.0", how),
      second_(weights, prefix + ".resnets.1", how) {}

at::Tensor MidBlock::operator()(at::Tensor frame, Memory& memory, VaePass& pass) const {
  frame = first_(std::move(frame), memory.first, pass);
  attention_(frame, pass);
  return second_(std::move(frame), memory.second, pass);
}

VaeHead::VaeHead(const WeightFiles& weights, const std::string& prefix, const VaeArithmetic& how)
    : norm_(weights, prefix + ".norm_out"), conv_(weights, prefix + ".conv_out", how) {}

at::Tensor VaeHead::operator()(const at::Tensor& frame, ConvMemory& memory, VaePass& pass) const {
  return convolved(norm_, conv_, pass.joined(frame, memory), memory, pass);
}

}  // namespace uwv::model
