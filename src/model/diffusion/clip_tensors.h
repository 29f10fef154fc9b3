// SPDX-License-Identifier: Apache-2.0
// A rendered clip as the autoencoder takes it: frames as tensors, asked for few at a time, of sides and a length that
// fit the network.
#pragma once

#include "model/vae/wan_vae.h"
#include "uwv/model/view_completion.h"

namespace uwv::model {

struct ClipTensors {
  std::int64_t frames = 0, height = 0, width = 0;
  ClipSource video;   ///< (1, 3, n, H, W) in [-1, 1].
  ClipSource mask;    ///< (1, 1, n, H, W) in [0, 1], 1 = generate.
  ClipSource source;  ///< As `video`: what the network may look at; empty = nothing.
  std::int64_t source_frames = 0;
};

/// Sides become multiples of 16 (a latent has 8 pixels, a token 2 latents) by repeating the last row and column, the
/// length 1 + 4k by repeating the last frame, masks alike. `clip` must outlive the result.
ClipTensors padded_tensors(const RenderedClip& clip);

/// (1, 3, 1, H, W) in [-1, 1].
at::Tensor to_tensor(const ImageRgb& picture);

}  // namespace uwv::model
