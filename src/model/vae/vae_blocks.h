// SPDX-License-Identifier: Apache-2.0
// What encoder and decoder are made of. Sheet model.md, 7. Everything takes one frame (H, W, C) at a time; what a
// block must remember of earlier frames, and of the band of rows above, is the caller's, so that one set of weights
// serves several passes. Of a band, a block takes the fresh rows and gives those it can make; see row_bands.h.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "model/vae/frame_conv.h"
#include "model/vae/rms_norm.h"
#include "model/vae/row_seam.h"

namespace uwv::model {

/// What a convolution remembers: of the band at hand the last frames, of the band above the last rows.
struct ConvMemory {
  BandStep step;
  FrameHistory frames;
  RowSeam seam;

  void enter(const BandStep& next) {
    step = next;
    frames = {};
  }
};

/// One way through a clip: where frames come from, and a call between blocks that may throw to stop it.
struct VaePass {
  FramePool pool;
  std::function<void()> between;
  BandPlace place{};
  FramePool seams{pool.type(), pool.device()};  ///< Of rows that wait for another band.

  /// A band carries what is around its rows, zeros where the picture ends included.
  RowEdge row_edge() const { return place.whole() ? RowEdge::zeros : RowEdge::carried; }
  /// The next band, whose frames have other sizes.
  void enter(const BandPlace& band);
  /// See RowSeam.
  at::Tensor joined(const at::Tensor& fresh, ConvMemory& memory) const;
};

/// norm, SiLU, conv, norm, SiLU, conv, plus the input (through a convolution of one pixel where the channels change).
class ResBlock {
 public:
  struct Memory {
    ConvMemory first, second;
    void enter(std::int64_t height, BandLines& lines);
  };
  ResBlock(const WeightFiles& weights, const std::string& prefix, const VaeArithmetic& how);
  /// May write into `frame`.
  at::Tensor operator()(at::Tensor frame, Memory& memory, VaePass& pass) const;

 private:
  RmsNorm norm1_, norm2_;
  CausalConv conv1_, conv2_;
  std::optional<PixelConv> shortcut_;
};

/// Attention of each pixel of a frame to all others, one head.
class FrameAttention {
 public:
  FrameAttention(const WeightFiles& weights, const std::string& prefix, const VaeArithmetic& how);
  /// Adds it to `frame`.
  void operator()(at::Tensor& frame, VaePass& pass) const;

 private:
  RmsNorm norm_;
  PixelConv to_qkv_, proj_;
};

class MidBlock {
 public:
  /// Of whole frames only.
  struct Memory {
    ResBlock::Memory first, second;
    void enter(std::int64_t height);
  };
  MidBlock(const WeightFiles& weights, const std::string& prefix, const VaeArithmetic& how);
  at::Tensor operator()(at::Tensor frame, Memory& memory, VaePass& pass) const;

 private:
  ResBlock first_;
  FrameAttention attention_;
  ResBlock second_;
};

/// norm, SiLU, conv: the end of both.
class VaeHead {
 public:
  VaeHead(const WeightFiles& weights, const std::string& prefix, const VaeArithmetic& how);
  at::Tensor operator()(const at::Tensor& frame, ConvMemory& memory, VaePass& pass) const;

 private:
  RmsNorm norm_;
  CausalConv conv_;
};

/// A frame of `rows` rows for a convolution to read, of a pool, with a row of zeros more where a band that is not the
/// whole picture meets the picture's end. `inside` are the rows to fill.
struct BorderedFrame {
  at::Tensor frame, inside;
};
BorderedFrame bordered_frame(const FramePool& pool, const BandPlace& place, const BandStep& step, std::int64_t rows,
                             std::int64_t width, std::int64_t channels);
/// (0, width, channels): what a layer that rests in a band hands on.
at::Tensor no_rows(const at::Tensor& like, std::int64_t width, std::int64_t channels);

}  // namespace uwv::model
