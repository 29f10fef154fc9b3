// SPDX-License-Identifier: Apache-2.0
// What the autoencoder will need, before it is loaded.
#pragma once

#include "model/vae/vae_config.h"
#include "model/vae/vae_options.h"

namespace uwv::model {

enum class VaeWay { encode, decode };

struct ClipSize {
  std::int64_t frames = 0, height = 0, width = 0;  ///< Of the clip, not of its latents.
};

/// Bytes the process holds at the most while it runs, its libraries and this half's weights included, the caller's clip
/// and latents not. docs/model-vae.md has it beside measured ones.
double estimated_peak_bytes(const VaeConfig& config, const ClipSize& size, const VaeOptions& options, VaeWay way);

/// Multiplications and additions, each counted as one, of all convolutions and the attention; bands add none.
double estimated_flops(const VaeConfig& config, const ClipSize& size, const VaeOptions& options, VaeWay way);

}  // namespace uwv::model
