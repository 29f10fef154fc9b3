// SPDX-License-Identifier: Apache-2.0
// From frames to latents. Sheet model.md, 7 ("Encoder"). Frames go through one at a time; four of them become one
// latent frame, the clip's first one alone.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "model/vae/row_bands.h"
#include "model/vae/vae_blocks.h"
#include "model/vae/wan_decoder.h"

namespace uwv::model {

class WanEncoder {
 public:
  WanEncoder(const WeightFiles& weights, const VaeConfig& config, const VaeArithmetic& how);

  /// The levels: all that looks at neighbouring pixels only, band after band from the top, through all frames of the
  /// clip each time.
  class Pass {
   public:
    /// At most `bands` of latents of `latent_height` rows. The encoder must outlive the pass.
    Pass(const WanEncoder& encoder, std::int64_t latent_height, int bands, std::function<void()> between,
         VaeProbe probe = {});
    std::size_t bands() const { return bands_.size(); }
    /// Goes to band `index`, one after the other from 0 on; the first needs no call.
    void enter(std::size_t index);
    /// For what follows the levels, until the next band is entered.
    const FramePool& pool() const { return pass_.pool; }
    /// Rows of the pictures that push() wants.
    Rows picture_rows() const { return bands_[band_].levels.front().in; }
    /// Takes the next frame (picture_rows, W, 3) in [-1, 1]; gives the band's rows of features (rows, w, C) when a
    /// latent frame is complete: after frames 0, 4, 8, ...
    std::optional<at::Tensor> push(const at::Tensor& frame);

   private:
    struct LevelMemory {
      std::vector<ResBlock::Memory> blocks;
      FrameHistory halving;
      ConvMemory resample;
      std::int64_t seen = 0;
    };
    void plan();
    at::Tensor begin(const at::Tensor& picture);
    at::Tensor halve_picture(std::size_t level, const at::Tensor& frame);
    std::optional<at::Tensor> halve_frames(std::size_t level, const at::Tensor& frame);

    const WanEncoder& encoder_;
    std::int64_t height_;  ///< Of the pictures.
    std::vector<BandRows> bands_;
    std::size_t band_ = 0;
    VaePass pass_;
    VaeProbe probe_;
    ConvMemory conv_in_;
    std::vector<LevelMemory> levels_;
  };

  /// What follows the levels, for whole latent frames.
  class Ending {
   public:
    Ending(const WanEncoder& encoder, const FramePool& pool, std::int64_t latent_height, std::function<void()> between,
           VaeProbe probe = {});
    /// features (h, w, C) -> (h, w, 2 z): mean, then logarithm of variance.
    at::Tensor push(at::Tensor features);

   private:
    const WanEncoder& encoder_;
    VaePass pass_;
    VaeProbe probe_;
    MidBlock::Memory mid_;
    ConvMemory head_;
  };

 private:
  struct Level {
    std::vector<ResBlock> blocks;
    FrameConv resample;  ///< Of all levels but the last.
    CausalConv halving;  ///< In time; where halves_frames.
    bool halves_frames = false;
  };

  VaeConfig config_;
  VaeArithmetic how_;
  c10::Device device_;  ///< Where the weights are.
  CausalConv conv_in_;
  std::vector<Level> levels_;
  MidBlock mid_;
  VaeHead head_;
  PixelConv quant_;
};

}  // namespace uwv::model
