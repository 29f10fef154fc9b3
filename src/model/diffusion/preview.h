// SPDX-License-Identifier: Apache-2.0
// A look at latents before they are decoded: the colour that goes with each latent, one pixel a latent, or one picture
// of the tiny decoder where there is one.
#pragma once

#include <ATen/core/Tensor.h>

#include "model/vae/tiny_vae.h"
#include "uwv/core/image.h"

namespace uwv::model {

/// An affine map from the 16 numbers of a latent to a colour, fitted to this clip's own known pictures and their
/// latents, so that it follows the autoencoder that is used.
class LatentColours {
 public:
  /// `latents` (1, 16, n, h, w) of `pictures` (3, n, h, w) in [-1, 1].
  LatentColours(const at::Tensor& latents, const at::Tensor& pictures);

  /// Frame `frame` of `latents`, `scale` pixels a latent.
  ImageRgb picture(const at::Tensor& latents, std::int64_t frame, int scale) const;

 private:
  at::Tensor map_;  ///< (17, 3), the last row the offset.
};

/// Frame `frame` of `latents` (1, z, n, h, w), decoded alone: without the frames before it, it is the still picture
/// that a clip beginning there would begin with, at a fraction of the work.
ImageRgb decoded_picture(const TinyVae& vae, const at::Tensor& latents, std::int64_t frame);

}  // namespace uwv::model
