// SPDX-License-Identifier: Apache-2.0
#include "model/vae/frame_conv.h"

#include <ATen/ATen.h>

#include "model/vae/frame_doubling.h"
#include "model/vae/winograd_conv.h"

namespace uwv::model {
namespace {

/// Channels that oneDNN works on at once; fewer take as long.
constexpr std::int64_t library_channels = 16;

/// (H, W, C) as the (1, C, H, W) that convolutions take; the numbers stay where they are.
at::Tensor as_picture(const at::Tensor& frame) { return frame.permute({2, 0, 1}).unsqueeze(0); }
at::Tensor as_frame(const at::Tensor& picture) { return picture.squeeze(0).permute({1, 2, 0}).contiguous(); }

}  // namespace

FrameConv::FrameConv(const at::Tensor& weight, const at::Tensor& bias, Edge edge, bool winograd)
    : bias_(bias), edge_(edge), winograd_(winograd && edge != Edge::halved && winograd::takes(weight)) {
  weight_ = winograd_ ? winograd::laid_out(weight) : weight.contiguous(at::MemoryFormat::ChannelsLast);
}

bool FrameConv::by_winograd(std::int64_t pixels) const { return winograd_ && winograd::pays(pixels); }

fused_conv::Steps FrameConv::steps(RowEdge rows) const {
  if (edge_ == Edge::halved) return {0, 0, 2};
  const std::int64_t around = weight_.size(2) / 2;
  return {rows == RowEdge::zeros ? around : 0, around, 1};
}

at::Tensor FrameConv::operator()(const at::Tensor& frame, const FramePool& pool, RowEdge rows) const {
  if (edge_ == Edge::doubled) return doubled_band(frame, pool, 0, 2 * frame.size(0));
  const std::int64_t height = frame.size(0) - (rows == RowEdge::carried ? 2 : 0);
  if (by_winograd(height * frame.size(1))) {
    at::Tensor result = pool.take(height, frame.size(1), results());
    winograd::convolve(pool, result, {{frame.contiguous(), weight_}}, bias_, false, false,
                       rows == RowEdge::carried ? 1 : 0);
    return result;
  }
  return as_frame(fused_conv::run(as_picture(frame), weight_, bias_, steps(rows)));
}

at::Tensor FrameConv::doubled_band(const at::Tensor& frame, const FramePool& pool, std::int64_t above,
                                   std::int64_t results) const {
  const std::int64_t width = 2 * frame.size(1), rows = 2 * frame.size(0);
  if (by_winograd(results * width)) {
    at::Tensor result = pool.take(results, width, weight_.size(0));
    winograd::convolve(pool, result, {{frame.contiguous(), weight_}}, bias_, false, true, above);
    return result;
  }
  if (above == 0 && results == rows)
    return as_frame(fused_conv::run(as_picture(doubled(frame)), weight_, bias_, {1, 1, 1}));
  // Rows of zeros where the frame ends but the result's surroundings do not.
  const std::int64_t zeros_above = 1 - above, zeros_below = results + 2 - rows - zeros_above;
  const at::Tensor large = pool.take(zeros_above + rows + zeros_below, width, frame.size(2));
  if (zeros_above > 0) large.narrow(0, 0, zeros_above).zero_();
  if (zeros_below > 0) large.narrow(0, zeros_above + rows, zeros_below).zero_();
  double_into(frame, large.narrow(0, zeros_above, rows));
  return as_frame(fused_conv::run(as_picture(large), weight_, bias_, {0, 1, 1}));
}

void FrameConv::add_to(at::Tensor& sum, const at::Tensor& frame, RowEdge rows) const {
  at::Tensor picture = as_picture(sum);
  fused_conv::add(picture, as_picture(frame), weight_, bias_, steps(rows));
}

CausalConv::CausalConv(const WeightFiles& weights, const std::string& prefix, const VaeArithmetic& how) {
  const at::Tensor stored = weights.view(prefix + ".weight");
  const at::Tensor bias = weights.load(prefix + ".bias", how.type);
  const auto tap = [&](std::int64_t back) { return stored.select(2, 2 - back).to(how.type); };
  const auto conv = [&](const at::Tensor& weight, bool with_bias) {
    return FrameConv(weight, with_bias ? bias : at::Tensor(), FrameConv::Edge::same, how.winograd);
  };
  const std::int64_t results = stored.size(0), channels = stored.size(1);
  if (3 * results <= channels) {
    form_ = Form::in_shares;
    bias_ = bias;
    taps_[0] = conv(at::cat({tap(0), tap(1), tap(2)}, 0), false);
  } else if (3 * channels <= library_channels) {
    form_ = Form::side_by_side;
    taps_[0] = conv(tap(0), true);
    taps_[1] = conv(at::cat({tap(0), tap(1)}, 1), true);
    taps_[2] = conv(at::cat({tap(0), tap(1), tap(2)}, 1), true);
  } else {
    for (std::int64_t back = 0; back < 3; ++back) taps_[back] = conv(tap(back), back == 0);
  }
  weights.release(prefix + ".weight");
}

at::Tensor CausalConv::side_by_side(const FrameHistory& history, const FramePool& pool, RowEdge rows) const {
  std::vector<at::Tensor> seen;
  for (std::size_t back = 0; back < history.size(); ++back) seen.push_back(history.frame(back));
  return taps_[history.size() - 1](at::cat(seen, 2), pool, rows);
}

at::Tensor CausalConv::in_shares(FrameHistory& history, const FramePool& pool, RowEdge rows) const {
  history.replace_newest(taps_[0](history.frame(0), pool, rows));
  const std::int64_t results = bias_.size(0);
  at::Tensor sum = history.frame(0).narrow(2, 0, results) + bias_;
  for (std::size_t back = 1; back < history.size(); ++back)
    sum.add_(history.frame(back).narrow(2, static_cast<std::int64_t>(back) * results, results));
  return sum;
}

void CausalConv::convolve(at::Tensor& sum, const FrameHistory& history, const FramePool& pool, bool add,
                          RowEdge rows) const {
  std::vector<winograd::Term> terms;
  for (std::size_t back = 0; back < history.size(); ++back)
    terms.push_back({history.frame(back), taps_[back].weight()});
  winograd::convolve(pool, sum, terms, taps_[0].bias(), add, false, rows == RowEdge::carried ? 1 : 0);
}

at::Tensor CausalConv::operator()(FrameHistory& history, const FramePool& pool, RowEdge rows) const {
  if (form_ != Form::by_frame) {
    at::Tensor sum = form_ == Form::in_shares ? in_shares(history, pool, rows) : side_by_side(history, pool, rows);
    history.keep(2);
    return sum;
  }
  const at::Tensor& newest = history.frame(0);
  const std::int64_t height = newest.size(0) - (rows == RowEdge::carried && taps_[0].weight().size(2) == 3 ? 2 : 0);
  if (taps_[0].by_winograd(height * newest.size(1))) {
    at::Tensor sum = pool.take(height, newest.size(1), results());
    convolve(sum, history, pool, false, rows);
    history.keep(2);
    return sum;
  }
  at::Tensor sum = taps_[0](newest, pool, rows);
  for (std::size_t back = 1; back < history.size(); ++back) taps_[back].add_to(sum, history.frame(back), rows);
  history.keep(2);
  return sum;
}

void CausalConv::add_to(at::Tensor& sum, FrameHistory& history, const FramePool& pool, RowEdge rows) const {
  if (form_ != Form::by_frame) {
    sum.add_((*this)(history, pool, rows));
    return;
  }
  if (sum.is_contiguous() && taps_[0].by_winograd(sum.size(0) * sum.size(1)))
    convolve(sum, history, pool, true, rows);
  else
    for (std::size_t back = 0; back < history.size(); ++back) taps_[back].add_to(sum, history.frame(back), rows);
  history.keep(2);
}

PixelConv::PixelConv(const WeightFiles& weights, const std::string& prefix, const VaeArithmetic& how)
    : weight_(weights.load(prefix + ".weight", how.type).flatten(1)), bias_(weights.load(prefix + ".bias", how.type)) {}

at::Tensor PixelConv::operator()(const at::Tensor& frame) const { return at::linear(frame, weight_, bias_); }

}  // namespace uwv::model
