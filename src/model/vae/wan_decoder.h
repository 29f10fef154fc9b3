// SPDX-License-Identifier: Apache-2.0
// From latents to frames. Sheet model.md, 7 ("Decoder").
//
// Frames go through one at a time, depth first: a latent frame becomes two frames, then four, each finished before the
// next is begun, so that only what the causal convolutions remember lives longer than a frame. Of bands, what lies
// before the levels is made once, for whole frames, because its attention sees all of a frame.
#pragma once

#include <deque>
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

  using Sink = std::function<void(const at::Tensor& frame)>;

  /// One clip, band after band from the top, through all its frames each time.
  class Pass {
   public:
    /// At most `bands` of latents of `latent_height` rows. `between` may throw to stop. The decoder must outlive the
    /// pass.
    Pass(const WanDecoder& decoder, std::int64_t latent_height, int bands, std::function<void()> between,
         VaeProbe probe = {});
    std::size_t bands() const { return bands_.size(); }
    /// Goes to band `index`, one after the other from 0 on; the first needs no call.
    void enter(std::size_t index);
    /// Takes the next latent frame (h, w, z), not normalised, all its rows; bands after the first do not look at it.
    /// Hands the band's rows of each frame (rows, W, 3) to `sink`, not clamped: 1 for the first latent frame, then 4.
    void push(const at::Tensor& latent, const Sink& sink);

   private:
    struct LevelMemory {
      std::vector<ResBlock::Memory> blocks;
      FrameHistory doubling;
      ConvMemory resample;
      bool begun = false;
    };
    void plan();
    at::Tensor before_levels(const at::Tensor& latent);
    at::Tensor doubled_frames(std::size_t level, const at::Tensor& frame);
    void push_level(std::size_t level, at::Tensor frame, const Sink& sink);
    void push_upsampled(std::size_t level, const at::Tensor& frame, const Sink& sink);

    const WanDecoder& decoder_;
    std::int64_t height_;
    std::vector<BandRows> bands_;
    std::size_t band_ = 0;
    VaePass whole_, pass_;  ///< Before the levels, and in them.
    VaeProbe probe_;
    FrameHistory conv_in_;
    MidBlock::Memory mid_;
    std::deque<at::Tensor> below_;  ///< Rows before the levels that wait for bands further down.
    ConvMemory head_;
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
  c10::Device device_;  ///< Where the weights are.
  PixelConv post_quant_;
  CausalConv conv_in_;
  MidBlock mid_;
  std::vector<Level> levels_;
  VaeHead head_;
};

}  // namespace uwv::model
