// SPDX-License-Identifier: Apache-2.0
// What the network is told about a clip: 96 channels at the latents' resolution. Sheet model.md, 4 (Conditioning).
//
// Channels 0..15 are the latents of what is known (holes grey), 16..31 those of what lies in the holes (the rest grey),
// 32..95 the mask, one channel for each of the 8x8 pixels under a latent, row by row.
#pragma once

#include <ATen/core/Tensor.h>

#include <cstdint>
#include <vector>

namespace uwv::model {

inline constexpr std::int64_t pixels_per_latent = 8;
inline constexpr std::int64_t frames_per_latent = 4;

/// Latent frames of a clip: the first frame has one of its own, four others share one.
constexpr std::int64_t latent_frames(std::int64_t frames) { return 1 + (frames - 1) / frames_per_latent; }
/// Frames of a latent clip.
constexpr std::int64_t frames_of(std::int64_t latents) { return 1 + (latents - 1) * frames_per_latent; }
/// The clip's length when it is made longer until its last latent is whole: 1 + 4k.
constexpr std::int64_t whole_frames(std::int64_t frames) {
  return 1 + (frames + frames_per_latent - 2) / frames_per_latent * frames_per_latent;
}

/// The frame whose mask stands for each latent frame: floor((i + 0.5) * frames / latents), in float32 as the reference
/// computes it. For 81 frames 1, 5, 9, ..: latent 0 does not take frame 0's mask.
std::vector<std::int64_t> mask_frames(std::int64_t frames, std::int64_t latents);

/// The clip with holes grey (0), and with all but the holes grey. `video` is (1, 3, T, H, W) in [-1, 1], `mask`
/// (1, 1, T, H, W) in [0, 1]; above 0.5 is a hole.
at::Tensor known_part(const at::Tensor& video, const at::Tensor& mask);
at::Tensor hole_part(const at::Tensor& video, const at::Tensor& mask);

/// (1, 64, latents, H / 8, W / 8) of one mask frame per latent frame, (1, 1, latents, H, W); values are not
/// thresholded.
at::Tensor mask_channels(const at::Tensor& mask);

}  // namespace uwv::model
