// SPDX-License-Identifier: Apache-2.0
// The autoencoder of Wan 2.1 (AutoencoderKLWan): clips to latents and back. Sheet model.md, 7.
//
// It runs on options.device; what comes in may lie anywhere, latents and frames come out on the CPU.
//
// The weights stay in their file; each call reads the half it needs and lets go of it at its end. Both ways stream:
// frames are asked for and handed out few at a time, and memory does not grow with the clip (with more than one band,
// what waits for the last band does: see VaeOptions::bands).
#pragma once

#include <functional>
#include <string>

#include "model/vae/vae_config.h"
#include "model/vae/vae_options.h"
#include "model/vae/vae_tiles.h"
#include "model/vae/wan_decoder.h"
#include "model/vae/wan_encoder.h"
#include "uwv/core/monitor.h"

namespace uwv::model {

/// Frames [first, first + count) of a clip: (1, 3, count, H, W), float32 in [-1, 1]. Asked in order, again from the
/// start for each band.
using ClipSource = std::function<at::Tensor(std::int64_t first, std::int64_t count)>;
/// Takes decoded frames, in order: (1, 3, n, H, W), float32 in [-1, 1], the first of which is frame `first`. n is 1,
/// then 4.
using ClipSink = std::function<void(std::int64_t first, const at::Tensor& frames)>;

class WanVae {
 public:
  /// `folder` holds config.json and the weights by diffusers' names. Throws Error (see WeightFiles and VaeConfig; every
  /// missing or misshaped tensor is named) and std::invalid_argument for options.
  static WanVae open(const std::string& folder, const VaeOptions& options = {});

  const VaeConfig& config() const { return config_; }
  const VaeOptions& options() const { return options_; }

  /// The normalised mean (1, z, 1 + (T - 1) / 4, H / 8, W / 8) of a clip of `frames` frames of `height` x `width`.
  /// Frames after the last 1 + 4k are not read. Throws Error: size_mismatch when a side is no multiple of 8 or no frame
  /// is there; value_invalid when a picture is not finite; cancelled.
  at::Tensor encode(const ClipSource& source, std::int64_t frames, std::int64_t height, std::int64_t width,
                    Monitor& monitor, const VaeProbe& probe = {}) const;
  at::Tensor encode(const at::Tensor& video, Monitor& monitor, const VaeProbe& probe = {}) const;

  /// Frames of normalised latents (1, z, T, h, w), clamped to [-1, 1]. Throws Error: size_mismatch, value_invalid when
  /// a latent is not finite, cancelled.
  void decode(const at::Tensor& latents, const ClipSink& sink, Monitor& monitor, const VaeProbe& probe = {}) const;
  /// All at once: (1, 3, 1 + 4 (T - 1), H, W).
  at::Tensor decode(const at::Tensor& latents, Monitor& monitor, const VaeProbe& probe = {}) const;

 private:
  WanVae(VaeConfig config, WeightFiles weights, const VaeOptions& options);
  VaeArithmetic arithmetic() const;
  TileGrid tiles(std::int64_t latent_height, std::int64_t latent_width, std::int64_t scale) const;
  at::Tensor encode_piece(const ClipSource& source, std::int64_t frames, std::int64_t height, Monitor& monitor,
                          const VaeProbe& probe) const;
  /// Not clamped.
  void decode_piece(const at::Tensor& latents, const ClipSink& sink, Monitor& monitor, const VaeProbe& probe) const;
  void decode_tiles(const TileGrid& grid, const at::Tensor& latents, const ClipSink& sink, Monitor& monitor) const;

  VaeConfig config_;
  WeightFiles weights_;
  VaeOptions options_;
  at::Tensor mean_, std_;  ///< (z)
};

}  // namespace uwv::model
