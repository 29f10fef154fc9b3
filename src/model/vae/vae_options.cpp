// SPDX-License-Identifier: Apache-2.0
#include "model/vae/vae_options.h"

#if defined(__x86_64__)
#include <cpuid.h>
#endif

#include "uwv/core/error.h"

namespace uwv::model {
namespace {

/// Intel's documented bit for tiles of bfloat16; the compiler's own question does not know it yet.
bool multiplies_bf16_tiles() {
#if defined(__x86_64__)
  unsigned a = 0, b = 0, c = 0, d = 0;
  return __get_cpuid_count(7, 0, &a, &b, &c, &d) != 0 && ((d >> 22) & 1U) != 0;
#else
  return false;
#endif
}

}  // namespace

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
  return multiplies_bf16_tiles() ? VaePrecision::bf16 : VaePrecision::f32;
}

}  // namespace uwv::model
