// SPDX-License-Identifier: Apache-2.0
#include "model/vae/frame_conv.h"

#include <ATen/ATen.h>

#include "model/vae/frame_doubling.h"
#include "model/vae/fused_conv.h"
#include "model/vae/winograd_conv.h"

namespace uwv::model {
namespace {

/// (H, W, C) as the (1, C, H, W) that convolutions take; the numbers stay where they are.
at::Tensor as_picture(const at::Tensor& frame) { return frame.permute({2, 0, 1}).unsqueeze(0); }
at::Tensor as_frame(const at::Tensor& picture) { return picture.squeeze(0).permute({1, 2, 0}).contiguous(); }

}  // namespace

FrameConv::FrameConv(const at::Tensor& weight, const at::Tensor& bias, Edge edge, bool winograd)
    : bias_(bias), edge_(edge), winograd_(winograd && edge != Edge::halved && winograd::takes(weight)) {
  weight_ = winograd_ ? winograd::laid_out(weight) : weight.contiguous(at::MemoryFormat::ChannelsLast);
}

bool FrameConv::by_winograd(std::int64_t pixels) const { return winograd_ && winograd::pays(pixels); }

at::Tensor FrameConv::operator()(const at::Tensor& frame) const {
  const std::int64_t scale = edge_ == Edge::doubled ? 2 : 1, height = scale * frame.size(0),
                     width = scale * frame.size(1);
  if (by_winograd(height * width)) {
    at::Tensor result = at::empty({height, width, weight_.size(0)}, frame.options());
    winograd::convolve(result, {{frame.contiguous(), weight_}}, bias_, false, edge_ == Edge::doubled);
    return result;
  }
  if (edge_ == Edge::doubled) return as_frame(fused_conv::run(as_picture(doubled(frame)), weight_, bias_, 1, 1));
  if (edge_ == Edge::halved) return as_frame(fused_conv::run(as_picture(frame), weight_, bias_, 0, 2));
  return as_frame(fused_conv::run(as_picture(frame), weight_, bias_, weight_.size(2) / 2, 1));
}

void FrameConv::add_to(at::Tensor& sum, const at::Tensor& frame) const {
  at::Tensor picture = as_picture(sum);
  const bool same = edge_ == Edge::same;
  fused_conv::add(picture, as_picture(frame), weight_, bias_, same ? weight_.size(2) / 2 : 0, same ? 1 : 2);
}

CausalConv::CausalConv(const WeightFiles& weights, const std::string& prefix, const VaeArithmetic& how) {
  const at::Tensor weight = weights.view(prefix + ".weight");
  const at::Tensor bias = weights.load(prefix + ".bias", how.type);
  for (std::int64_t back = 0; back < 3; ++back)
    taps_[back] = FrameConv(weight.select(2, 2 - back).to(how.type), back == 0 ? bias : at::Tensor(),
                            FrameConv::Edge::same, how.winograd);
  weights.release(prefix + ".weight");
}

void CausalConv::convolve(at::Tensor& sum, const FrameHistory& history, bool add) const {
  std::vector<winograd::Term> terms;
  for (std::size_t back = 0; back < history.size(); ++back)
    terms.push_back({history.frame(back), taps_[back].weight()});
  winograd::convolve(sum, terms, taps_[0].bias(), add);
}

at::Tensor CausalConv::operator()(FrameHistory& history, FramePool& pool) const {
  const at::Tensor& newest = history.frame(0);
  if (taps_[0].by_winograd(newest.size(0) * newest.size(1))) {
    at::Tensor sum = at::empty({newest.size(0), newest.size(1), taps_[0].weight().size(0)}, newest.options());
    convolve(sum, history, false);
    history.keep(2, pool);
    return sum;
  }
  at::Tensor sum = taps_[0](history.frame(0));
  for (std::size_t back = 1; back < history.size(); ++back) taps_[back].add_to(sum, history.frame(back));
  history.keep(2, pool);
  return sum;
}

void CausalConv::add_to(at::Tensor& sum, FrameHistory& history, FramePool& pool) const {
  if (sum.is_contiguous() && taps_[0].by_winograd(sum.size(0) * sum.size(1)))
    convolve(sum, history, true);
  else
    for (std::size_t back = 0; back < history.size(); ++back) taps_[back].add_to(sum, history.frame(back));
  history.keep(2, pool);
}

PixelConv::PixelConv(const WeightFiles& weights, const std::string& prefix, const VaeArithmetic& how)
    : weight_(weights.load(prefix + ".weight", how.type).flatten(1)), bias_(weights.load(prefix + ".bias", how.type)) {}

at::Tensor PixelConv::operator()(const at::Tensor& frame) const { return at::linear(frame, weight_, bias_); }

}  // namespace uwv::model
