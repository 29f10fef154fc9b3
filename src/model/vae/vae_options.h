// SPDX-License-Identifier: Apache-2.0
// What the autoencoder trades: accuracy and time for memory. docs/model-vae.md has the measured cost of each.
#pragma once

#include <c10/core/Device.h>

#include <cstdint>
#include <string_view>

namespace uwv::model {

/// In what numbers the autoencoder computes.
enum class VaePrecision {
  automatic,  ///< bf16 where the processor multiplies it in tiles (AMX), f32 elsewhere.
  f32,        ///< The exact answer: within 1e-4 of the reference.
  bf16,       ///< Half the memory; what that costs in PSNR is in the docs.
};
std::string_view to_string(VaePrecision precision);
/// By its name. Throws Error(value_invalid).
VaePrecision vae_precision(std::string_view name);

struct VaeOptions {
  VaePrecision precision = VaePrecision::f32;
  /// The picture is worked on in so many horizontal bands, one after the other through the whole clip: the same
  /// numbers as in one piece, in little more than 1/bands of the memory. No row is made twice; the last rows of what
  /// each convolution reads are kept for the band below, of every frame, and all but the last band's finished rows wait
  /// (vae_cost.h reckons both). 1 = one piece. Low pictures are made in fewer bands; see row_bands.h.
  int bands = 1;
  /// Convolutions of 3x3 in float32 by Winograd's way (winograd_conv.h): a quarter of the products, four times the
  /// rounding, which is still far below what tells two implementations apart. Off to compare with.
  bool winograd = true;

  /// Pixels of the side of square tiles, 0 = none; and from one tile to the next, 0 = three quarters of a tile. See
  /// vae_tiles.h: for pictures so large that the attention over all of a frame's latents is what takes the time. Each
  /// tile may be worked on in bands as well. Both are multiples of 8. The whole clip's result waits in memory.
  int tile = 0, tile_stride = 0;

  c10::Device device = c10::kCPU;  ///< Where it is run; see compute_device().

  int stride() const { return tile_stride > 0 ? tile_stride : tile / 32 * 24; }
  /// Throws std::invalid_argument.
  void check() const;
};

/// What `automatic` means on this processor.
VaePrecision resolved(VaePrecision precision);

}  // namespace uwv::model
