// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/conditioning.h"

#include <ATen/ATen.h>

#include <algorithm>

#include "uwv/core/error.h"

namespace uwv::model {

std::vector<std::int64_t> mask_frames(std::int64_t frames, std::int64_t latents) {
  const float scale = static_cast<float>(frames) / static_cast<float>(latents);
  std::vector<std::int64_t> picked;
  for (std::int64_t i = 0; i < latents; ++i)
    picked.push_back(std::min(static_cast<std::int64_t>((static_cast<float>(i) + 0.5F) * scale), frames - 1));
  return picked;
}

at::Tensor known_part(const at::Tensor& video, const at::Tensor& mask) { return video * mask.le(0.5); }

at::Tensor hole_part(const at::Tensor& video, const at::Tensor& mask) { return video * mask.gt(0.5); }

at::Tensor mask_channels(const at::Tensor& mask) {
  require(mask.dim() == 5 && mask.size(1) == 1 && mask.size(3) % pixels_per_latent == 0 &&
              mask.size(4) % pixels_per_latent == 0,
          "mask: found {} dimensions and {} rows of {}, wanted (1, 1, T, H, W) with sides that {} divides", mask.dim(),
          mask.dim() > 3 ? mask.size(3) : 0, mask.dim() > 4 ? mask.size(4) : 0, pixels_per_latent);
  return at::pixel_unshuffle(mask[0].transpose(0, 1), pixels_per_latent).transpose(0, 1).unsqueeze(0).contiguous();
}

}  // namespace uwv::model
