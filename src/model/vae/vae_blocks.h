// SPDX-License-Identifier: Apache-2.0
// What encoder and decoder are made of. Sheet model.md, 7. Everything takes one frame (H, W, C) at a time; what a
// block must remember of earlier frames is the caller's, so that one set of weights serves several passes.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "model/vae/frame_conv.h"
#include "model/vae/rms_norm.h"

namespace uwv::model {

/// One pass through a clip: where frames come from, and a call between blocks that may throw to stop it.
struct VaePass {
  FramePool pool;
  std::function<void()> between;
};

/// norm, SiLU, conv, norm, SiLU, conv, plus the input (through a convolution of one pixel where the channels change).
class ResBlock {
 public:
  struct Memory {
    FrameHistory first, second;
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
  at::Tensor operator()(at::Tensor frame, VaePass& pass) const;

 private:
  RmsNorm norm_;
  PixelConv to_qkv_, proj_;
};

class MidBlock {
 public:
  struct Memory {
    ResBlock::Memory first, second;
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
  at::Tensor operator()(const at::Tensor& frame, FrameHistory& memory, VaePass& pass) const;

 private:
  RmsNorm norm_;
  CausalConv conv_;
};

}  // namespace uwv::model
