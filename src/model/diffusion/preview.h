// SPDX-License-Identifier: Apache-2.0
// A look at latents without decoding them: the colour that goes with each latent, one pixel a latent.
#pragma once

#include <ATen/core/Tensor.h>

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

}  // namespace uwv::model
