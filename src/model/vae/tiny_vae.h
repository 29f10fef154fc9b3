// SPDX-License-Identifier: Apache-2.0
// A small stand-in for the autoencoder's decoder: TAEHV's layout as trained for Wan 2.1 (taew2_1). A hundredth of the
// work for pictures that lose fine detail; for previews, and for `--vae-fast`. docs/model-vae.md has both measured.
//
// The network, by the numbers in its keys "decoder.N": 1 convolution, 3 to 5 blocks, 7 frames, 8 convolution and
// halving of channels, 9 to 11, 13, 14, 15 to 17, 19, 20 likewise, 22 convolution to colours. Blocks see the frame
// before; 13 and 19 make two frames of one; before 8, 14 and 20 the picture doubles. Four frames come of every latent
// frame, and the clip's first three are not shown: 1 + 4 (T - 1), as from the large decoder.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "model/vae/vae_options.h"
#include "model/vae/wan_vae.h"

namespace uwv::model {

class TinyVae {
 public:
  /// `path` is a safetensors file, or a folder with one. Widths are read from it. Of `options`, only precision and
  /// device count. Throws Error: see WeightFiles; value_invalid when it is no decoder of this layout (others of the
  /// family, as for Wan 2.2, are not).
  static TinyVae open(const std::string& path, const VaeOptions& options = {});
  /// Throws as open() would, and Error(value_invalid) when it takes other latents than `z_dim` channels; reads only
  /// headers.
  static void check(const std::string& path, std::int64_t z_dim);

  /// Latent channels it was made for.
  std::int64_t z_dim() const { return conv_in_.channels(); }
  /// As WanVae::decode: normalised latents (1, z, T, h, w) to frames of 8h x 8w in [-1, 1], 1 and then 4 at a time.
  void decode(const at::Tensor& latents, const ClipSink& sink, Monitor& monitor) const;
  at::Tensor decode(const at::Tensor& latents, Monitor& monitor) const;

 private:
  /// Three convolutions of this frame and the one before, plus this frame.
  struct Block {
    FrameConv current, before, second, third;
  };
  struct Level {
    std::vector<Block> blocks;
    at::Tensor grow;  ///< (frames * C, C): one frame as `frames`.
    std::int64_t frames = 1;
    FrameConv resample;
  };
  struct Pass;
  void push(std::size_t level, at::Tensor frame, Pass& pass) const;

  TinyVae() = default;

  at::ScalarType type_ = at::kFloat;
  c10::Device device_ = c10::kCPU;
  FrameConv conv_in_, conv_out_;
  std::vector<Level> levels_;
};

}  // namespace uwv::model
