// SPDX-License-Identifier: Apache-2.0
// Convolutions of single frames that lie pixel by pixel, and the causal one over three frames that is made of them.
//
// A causal convolution of 3x3x3 is run as three of 3x3, one per frame it looks at, summed in place: frames then need
// not lie behind one another in memory, nothing is copied together, and the frames of zeros before a clip's first one
// cost nothing.
#pragma once

#include <ATen/core/Tensor.h>

#include <array>

#include "model/vae/frame_pool.h"
#include "model/vae/fused_conv.h"
#include "model/weights/weight_files.h"

namespace uwv::model {

/// In what numbers convolutions work, and how.
struct VaeArithmetic {
  at::ScalarType type = at::kFloat;
  bool winograd = true;  ///< See winograd_conv.h; for float32 kernels of 3x3 where it pays.
};

/// What lies above a frame's first row and below its last one.
enum class RowEdge {
  zeros,    ///< The picture's end.
  carried,  ///< Nothing: the frame brings the rows around those of the answer, one above and one below.
};

/// (H, W, C) -> (H', W', O), contiguous, in the type of the weight.
class FrameConv {
 public:
  enum class Edge {
    same,     ///< Zeros all around, so that the size stays.
    halved,   ///< Stride 2 without zeros: (H - 3) / 2 + 1.
    doubled,  ///< As `same`, of the frame at twice its size, each pixel 2x2.
  };
  FrameConv() = default;
  /// `weight` is (O, C, k, k), `bias` (O) or undefined.
  FrameConv(const at::Tensor& weight, const at::Tensor& bias, Edge edge, bool winograd = true);

  /// C.
  std::int64_t channels() const { return weight_.size(1); }
  /// O.
  std::int64_t results() const { return weight_.size(0); }
  at::Tensor operator()(const at::Tensor& frame, const FramePool& pool, RowEdge rows = RowEdge::zeros) const;
  /// Of Edge::doubled, for a band: `results` rows, the first of which looks at row `above` - 1 of the doubled frame
  /// (0 or 1; none of -1 and beyond the last: zeros).
  at::Tensor doubled_band(const at::Tensor& frame, const FramePool& pool, std::int64_t above,
                          std::int64_t results) const;
  /// sum += what operator() gives, without a frame in between where the library can.
  void add_to(at::Tensor& sum, const at::Tensor& frame, RowEdge rows = RowEdge::zeros) const;

  /// Whether a result of `pixels` pixels is made by winograd::convolve().
  bool by_winograd(std::int64_t pixels) const;
  const at::Tensor& weight() const { return weight_; }
  const at::Tensor& bias() const { return bias_; }

 private:
  fused_conv::Steps steps(RowEdge rows) const;

  at::Tensor weight_, bias_;
  Edge edge_ = Edge::same;
  bool winograd_ = true;
};

/// Sheet model.md, 7: a kernel of (3, k, k) that sees the current frame and the two before.
///
/// The network's ends are run otherwise, because a library fills few channels up to its own number. Few inputs: the
/// three frames' channels are put side by side, for one convolution. Few results: one convolution of the newest frame
/// gives its share in three results, and these shares are remembered instead of the frame: of the decoder's 96 channels
/// at full size, nine.
class CausalConv {
 public:
  CausalConv() = default;
  /// Reads prefix + ".weight" (O, C, 3, k, k) and ".bias" (O).
  CausalConv(const WeightFiles& weights, const std::string& prefix, const VaeArithmetic& how);

  std::int64_t results() const { return form_ == Form::in_shares ? bias_.size(0) : taps_[0].results(); }
  /// The answer for the newest frame of `history`, of which it keeps the newest two.
  at::Tensor operator()(FrameHistory& history, const FramePool& pool, RowEdge rows = RowEdge::zeros) const;
  void add_to(at::Tensor& sum, FrameHistory& history, const FramePool& pool, RowEdge rows = RowEdge::zeros) const;

 private:
  enum class Form {
    by_frame,      ///< Each frame by its own tap.
    side_by_side,  ///< Few inputs.
    in_shares,     ///< Few results.
  };
  /// By Winograd, all frames at once.
  void convolve(at::Tensor& sum, const FrameHistory& history, const FramePool& pool, bool add, RowEdge rows) const;
  at::Tensor side_by_side(const FrameHistory& history, const FramePool& pool, RowEdge rows) const;
  at::Tensor in_shares(FrameHistory& history, const FramePool& pool, RowEdge rows) const;

  Form form_ = Form::by_frame;
  /// By how many frames back, the bias with the newest; side by side: by how many frames there are before the newest;
  /// in shares: the first alone, (3 O, C, k, k), results of the newest tap first.
  std::array<FrameConv, 3> taps_;
  at::Tensor bias_;  ///< In shares.
};

/// A convolution of one pixel, which is a linear layer.
class PixelConv {
 public:
  PixelConv() = default;
  /// Reads prefix + ".weight" (O, C, 1, 1) or (O, C, 1, 1, 1) and ".bias" (O).
  PixelConv(const WeightFiles& weights, const std::string& prefix, const VaeArithmetic& how);

  /// (..., C) -> (..., O).
  at::Tensor operator()(const at::Tensor& frame) const;

 private:
  at::Tensor weight_, bias_;
};

}  // namespace uwv::model
