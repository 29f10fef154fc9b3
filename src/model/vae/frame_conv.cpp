// SPDX-License-Identifier: Apache-2.0
#include "model/vae/frame_conv.h"

#include <ATen/ATen.h>

#include "model/vae/fused_conv.h"

namespace uwv::model {
namespace {

/// (H, W, C) as the (1, C, H, W) that convolutions take; the numbers stay where they are.
at::Tensor as_picture(const at::Tensor& frame) { return frame.permute({2, 0, 1}).unsqueeze(0); }
at::Tensor as_frame(const at::Tensor& picture) { return picture.squeeze(0).permute({1, 2, 0}).contiguous(); }

}  // namespace

FrameConv::FrameConv(const at::Tensor& weight, const at::Tensor& bias, Edge edge)
    : weight_(weight.contiguous(at::MemoryFormat::ChannelsLast)), bias_(bias), edge_(edge) {}

at::Tensor FrameConv::operator()(const at::Tensor& frame) const {
  if (edge_ == Edge::halved) return as_frame(fused_conv::run(as_picture(frame), weight_, bias_, 0, 2));
  return as_frame(fused_conv::run(as_picture(frame), weight_, bias_, weight_.size(2) / 2, 1));
}

void FrameConv::add_to(at::Tensor& sum, const at::Tensor& frame) const {
  at::Tensor picture = as_picture(sum);
  const bool same = edge_ == Edge::same;
  fused_conv::add(picture, as_picture(frame), weight_, bias_, same ? weight_.size(2) / 2 : 0, same ? 1 : 2);
}

CausalConv::CausalConv(const WeightFiles& weights, const std::string& prefix, at::ScalarType type) {
  const at::Tensor weight = weights.view(prefix + ".weight");
  const at::Tensor bias = weights.load(prefix + ".bias", type);
  for (std::int64_t back = 0; back < 3; ++back)
    taps_[back] =
        FrameConv(weight.select(2, 2 - back).to(type), back == 0 ? bias : at::Tensor(), FrameConv::Edge::same);
  weights.release(prefix + ".weight");
}

at::Tensor CausalConv::operator()(FrameHistory& history, FramePool& pool) const {
  at::Tensor sum = taps_[0](history.frame(0));
  for (std::size_t back = 1; back < history.size(); ++back) taps_[back].add_to(sum, history.frame(back));
  history.keep(2, pool);
  return sum;
}

void CausalConv::add_to(at::Tensor& sum, FrameHistory& history, FramePool& pool) const {
  for (std::size_t back = 0; back < history.size(); ++back) taps_[back].add_to(sum, history.frame(back));
  history.keep(2, pool);
}

PixelConv::PixelConv(const WeightFiles& weights, const std::string& prefix, at::ScalarType type)
    : weight_(weights.load(prefix + ".weight", type).flatten(1)), bias_(weights.load(prefix + ".bias", type)) {}

at::Tensor PixelConv::operator()(const at::Tensor& frame) const { return at::linear(frame, weight_, bias_); }

}  // namespace uwv::model
