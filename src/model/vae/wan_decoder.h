// SPDX-License-Identifier: Apache-2.0
// From latents to frames. Sheet model.md, 7 ("Decoder").
//
// Frames go through one at a time, depth first: a latent frame becomes two frames, then four, each finished before the
// next is begun, so that only what the causal convolutions remember lives longer than a frame.
#pragma once

#include <functional>
#include <string_view>
#include <vector>

#include "model/vae/row_bands.h"
#include "model/vae/vae_blocks.h"

namespace uwv::model {

/// Shown what a named part gave, frame by frame, for comparison with other implementations. Parts: "conv_in",
/// "mid_block" (latent rows), "out" (before clamping).
using VaeProbe = std::function<void(std::string_view part, const at::Tensor& frame)>;

class WanDecoder {
 public:
  WanDecoder(const WeightFiles& weights, const VaeConfig& config, const VaeArithmetic& how);

  /// One pass through a clip.
  class Pass {
   public:
    /// `rows` of latents out of `latent_height`. `between` may throw to stop. The decoder must outlive the pass.
    Pass(const WanDecoder& decoder, std::int64_t latent_height, Rows rows, std::function<void()> between,
         VaeProbe probe = {});
    /// Takes the next latent frame (h, w, z), not normalised, all its rows. Hands each frame (8 rows per row of
    /// latents, W, 3) to `sink`, not clamped: 1 for the first latent frame, then 4.
    void push(const at::Tensor& latent, const std::function<void(const at::Tensor& frame)>& sink);

   private:
    struct LevelMemory {
      std::vector<ResBlock::Memory> blocks;
      FrameHistory doubling;
      bool begun = false;
    };
    void push_level(std::size_t level, at::Tensor frame, const std::function<void(const at::Tensor&)>& sink);
    void push_upsampled(std::size_t level, const at::Tensor& frame, const std::function<void(const at::Tensor&)>& sink);

    const WanDecoder& decoder_;
    std::vector<LevelRows> rows_;
    VaePass pass_;
    VaeProbe probe_;
    FrameHistory conv_in_, head_;
    MidBlock::Memory mid_;
    std::vector<LevelMemory> levels_;
  };

 private:
  struct Level {
    std::vector<ResBlock> blocks;
    CausalConv doubling;  ///< In time; where doubles_frames.
    bool doubles_frames = false;
    FrameConv resample;  ///< Of all levels but the last.
  };

  VaeConfig config_;
  VaeArithmetic how_;
  PixelConv post_quant_;
  CausalConv conv_in_;
  MidBlock mid_;
  std::vector<Level> levels_;
  VaeHead head_;
};

}  // namespace uwv::model
