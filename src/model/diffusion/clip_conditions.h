// SPDX-License-Identifier: Apache-2.0
// A clip encoded into what the network is told about it. Sheet model.md, 4.
#pragma once

#include <vector>

#include "model/diffusion/clip_tensors.h"

namespace uwv::model {

/// Frames of the source that the network is shown for a window.
inline constexpr std::int64_t reference_frames = 9;

struct ClipConditions {
  at::Tensor control;           ///< (1, 96, latents, h, w): known, holes, mask. Undefined when there is no hole.
  std::vector<bool> has_holes;  ///< By latent frame: in any of its frames.
  at::Tensor unknown_tokens;    ///< (latents, token rows, token columns): whether any of its pixels is a hole.
  at::Tensor small_pictures;    ///< (3, latents, h, w) in [-1, 1]: each latent's own piece of picture, averaged.

  bool any_hole() const;
  bool any_hole(std::int64_t first, std::int64_t count) const;
};

ClipConditions encode_conditions(const WanVae& vae, const ClipTensors& clip, Monitor& monitor);

/// The reference: latents (1, 16, n, h, w) of the source's frames from `first` on, as many as the official code's ten
/// frames give (nine are read, three latents), fewer where the source is shorter; from an earlier frame where it ends
/// before.
at::Tensor encode_reference(const WanVae& vae, const ClipTensors& clip, std::int64_t first, Monitor& monitor);

}  // namespace uwv::model
