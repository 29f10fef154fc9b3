// SPDX-License-Identifier: Apache-2.0
#include "model/vae/vae_options.h"

#include "uwv/core/error.h"
#include "uwv/core/processor.h"

namespace uwv::model {

std::string_view to_string(VaePrecision precision) {
  switch (precision) {
    case VaePrecision::automatic: return "auto";
    case VaePrecision::f32: return "f32";
    case VaePrecision::bf16: return "bf16";
  }
  return "";
}

VaePrecision vae_precision(std::string_view name) {
  for (const VaePrecision precision : {VaePrecision::automatic, VaePrecision::f32, VaePrecision::bf16})
    if (name == to_string(precision)) return precision;
  fail(ErrorCode::value_invalid, "'{}' is no precision of the autoencoder; auto, f32 or bf16 is wanted", name);
}

void VaeOptions::check() const {
  require(bands >= 1 && bands <= 64, "VaeOptions: bands is {}; 1 to 64 are wanted", bands);
  require(tile == 0 || (tile >= 32 && tile % 8 == 0), "VaeOptions: tile is {}; 0 or a multiple of 8 from 32 is wanted",
          tile);
  require(tile == 0 || (stride() > 0 && stride() <= tile && stride() % 8 == 0),
          "VaeOptions: tile_stride is {} for tiles of {}; a multiple of 8 up to the tile is wanted", stride(), tile);
}

VaePrecision resolved(VaePrecision precision) {
  if (precision != VaePrecision::automatic) return precision;
  return processor_units().amx_bf16 ? VaePrecision::bf16 : VaePrecision::f32;
}

}  // namespace uwv::model
