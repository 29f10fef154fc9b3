// SPDX-License-Identifier: Apache-2.0
// The sizes of an AutoencoderKLWan, from its folder's config.json. Sheet model.md, 7.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace uwv::model {

struct VaeConfig {
  std::int64_t base_dim = 96;
  std::int64_t decoder_base_dim = 96;
  std::vector<std::int64_t> dim_mult{1, 2, 4, 4};
  std::int64_t num_res_blocks = 2;                           ///< The decoder has one more.
  std::vector<bool> temperal_downsample{false, true, true};  ///< One per level but the last; the key's own spelling.
  std::int64_t z_dim = 16;
  std::vector<float> latents_mean, latents_std;  ///< z_dim each; normalised = (raw - mean) / std.

  /// Reads config.json. Throws Error: file_not_found, file_damaged, or value_invalid naming the key, also for variants
  /// this code does not have: residual ones, patched ones, attention outside the middle.
  static VaeConfig read(const std::string& path);

  std::size_t levels() const { return dim_mult.size(); }
  /// Pixels a latent is wide, frames it lasts.
  std::int64_t spatial_factor() const { return std::int64_t{1} << (levels() - 1); }
  std::int64_t temporal_factor() const;
  /// Latent frames of a clip; frames past 1 + 4k are not counted, as they are not read.
  std::int64_t latent_frames(std::int64_t frames) const { return 1 + (frames - 1) / temporal_factor(); }
  std::int64_t frames_of(std::int64_t latent_frames) const { return 1 + (latent_frames - 1) * temporal_factor(); }
};

}  // namespace uwv::model
