// SPDX-License-Identifier: Apache-2.0
// Which numbers this processor multiplies faster than float32.
#pragma once

#include <string>

namespace uwv {

struct ProcessorUnits {
  bool avx2 = false, avx512 = false;
  bool avx512_bf16 = false, amx_bf16 = false;  ///< bfloat16: in vectors, in tiles.
  bool vnni = false, amx_int8 = false;         ///< 8-bit integers: in vectors (AVX or AVX-512), in tiles.

  bool int8() const { return vnni || amx_int8; }
  /// For people: "avx2, avx512, amx_bf16", or "none of those looked for".
  std::string names() const;
};

/// Asks the processor; all false where it is not an x86.
ProcessorUnits processor_units();

}  // namespace uwv
