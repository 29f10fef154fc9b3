// SPDX-License-Identifier: Apache-2.0
// What the tiny decoder will need, before it is loaded.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "model/vae/vae_cost.h"

namespace uwv::model {

/// Widths of a TAEHV decoder (tiny_vae.h); as published, unless read.
struct TinyVaeSizes {
  std::int64_t z_dim = 16;
  std::array<std::int64_t, 3> levels{256, 128, 64};
  std::int64_t last = 64;  ///< Channels at full size, of which colours are made.

  /// Reads only headers, of a file that TinyVae::check() takes.
  static TinyVaeSizes read(const std::string& path);
};

/// Multiplications and additions, each counted as one. A clip of one frame is also what a preview costs.
double estimated_flops(const TinyVaeSizes& sizes, const ClipSize& clip);

/// Bytes of its weights.
double estimated_weight_bytes(const TinyVaeSizes& sizes, VaePrecision precision);

/// Bytes of frames while it decodes, weights not included. A clip's length does not count.
double estimated_working_bytes(const TinyVaeSizes& sizes, const ClipSize& clip, VaePrecision precision);

/// Bytes the process holds at the most, its libraries included, the caller's clip and latents not.
double estimated_peak_bytes(const TinyVaeSizes& sizes, const ClipSize& clip, VaePrecision precision);

}  // namespace uwv::model
