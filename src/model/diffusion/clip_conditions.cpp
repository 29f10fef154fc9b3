// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/clip_conditions.h"

#include <ATen/ATen.h>

#include <algorithm>

#include "model/diffusion/conditioning.h"

namespace uwv::model {
namespace {

constexpr std::int64_t pixels_per_token = 2 * pixels_per_latent;

/// What the masks say, from one walk through them.
struct MaskLook {
  at::Tensor channels;  ///< (1, 64, latents, h, w)
  std::vector<bool> has_holes;
  at::Tensor unknown_tokens;
};

MaskLook look_at_masks(const ClipTensors& clip, Monitor& monitor) {
  const std::int64_t latents = latent_frames(clip.frames);
  const std::vector<std::int64_t> picked = mask_frames(clip.frames, latents);
  MaskLook look{{},
                std::vector<bool>(static_cast<std::size_t>(latents)),
                at::zeros({latents, clip.height / pixels_per_token, clip.width / pixels_per_token}, at::kBool)};
  std::vector<at::Tensor> channels;
  for (std::int64_t k = 0; k < clip.frames; ++k) {
    const at::Tensor mask = clip.mask(k, 1);
    const std::int64_t latent = (k + frames_per_latent - 1) / frames_per_latent;
    look.unknown_tokens[latent].logical_or_(at::max_pool2d(mask[0].transpose(0, 1), pixels_per_token)[0][0].gt(0));
    if (std::binary_search(picked.begin(), picked.end(), k)) channels.push_back(mask_channels(mask));
    monitor.step("masks", k + 1, clip.frames);
  }
  for (std::int64_t i = 0; i < latents; ++i)
    look.has_holes[static_cast<std::size_t>(i)] = look.unknown_tokens[i].any().item<bool>();
  look.channels = at::cat(channels, 2);
  return look;
}

at::Tensor small_pictures(const ClipTensors& clip) {
  const std::int64_t latents = latent_frames(clip.frames);
  std::vector<at::Tensor> pictures;
  for (const std::int64_t k : mask_frames(clip.frames, latents))
    pictures.push_back(at::avg_pool2d(clip.video(k, 1).squeeze(2), pixels_per_latent)[0].unsqueeze(1));
  return at::cat(pictures, 1);
}

}  // namespace

bool ClipConditions::any_hole() const { return any_hole(0, static_cast<std::int64_t>(has_holes.size())); }

bool ClipConditions::any_hole(std::int64_t first, std::int64_t count) const {
  return std::find(has_holes.begin() + first, has_holes.begin() + first + count, true) !=
         has_holes.begin() + first + count;
}

ClipConditions encode_conditions(const WanVae& vae, const ClipTensors& clip, Monitor& monitor) {
  MaskLook masks = look_at_masks(clip, monitor);
  ClipConditions conditions{{}, std::move(masks.has_holes), masks.unknown_tokens, {}};
  if (!conditions.any_hole()) return conditions;
  const auto part = [&](at::Tensor (*choose)(const at::Tensor&, const at::Tensor&)) {
    return vae.encode(
        [&clip, choose](std::int64_t first, std::int64_t count) {
          return choose(clip.video(first, count), clip.mask(first, count));
        },
        clip.frames, clip.height, clip.width, monitor);
  };
  const at::Tensor known = part(known_part);
  conditions.control = at::cat({known, part(hole_part), masks.channels}, 1);
  conditions.small_pictures = small_pictures(clip);
  return conditions;
}

at::Tensor encode_reference(const WanVae& vae, const ClipTensors& clip, std::int64_t first, Monitor& monitor) {
  const std::int64_t frames = frames_of(latent_frames(std::min(reference_frames, clip.source_frames)));
  const std::int64_t begin = std::clamp<std::int64_t>(first, 0, clip.source_frames - frames);
  return vae.encode([&clip, begin](std::int64_t at, std::int64_t count) { return clip.source(begin + at, count); },
                    frames, clip.height, clip.width, monitor);
}

}  // namespace uwv::model
