// SPDX-License-Identifier: Apache-2.0
#include "uwv/core/processor.h"

#include <utility>

#if defined(__x86_64__)
#include <cpuid.h>
#endif

namespace uwv {

ProcessorUnits processor_units() {
  ProcessorUnits units;
#if defined(__x86_64__)
  // Intel's manual, volume 2, CPUID leaf 7; the compiler's own question does not know the newest bits.
  unsigned a = 0, b = 0, c = 0, d = 0, a1 = 0, b1 = 0, c1 = 0, d1 = 0;
  if (__get_cpuid_count(7, 0, &a, &b, &c, &d) == 0) return units;
  __get_cpuid_count(7, 1, &a1, &b1, &c1, &d1);
  const auto bit = [](unsigned word, unsigned place) { return ((word >> place) & 1U) != 0; };
  units.avx2 = bit(b, 5);
  units.avx512 = bit(b, 16);
  units.vnni = bit(c, 11) || bit(a1, 4);
  units.avx512_bf16 = bit(a1, 5);
  units.amx_bf16 = bit(d, 22);
  units.amx_int8 = bit(d, 25);
#endif
  return units;
}

std::string ProcessorUnits::names() const {
  std::string all;
  for (const auto& [has, name] : {std::pair{avx2, "avx2"},
                                  {avx512, "avx512"},
                                  {avx512_bf16, "avx512_bf16"},
                                  {amx_bf16, "amx_bf16"},
                                  {vnni, "vnni"},
                                  {amx_int8, "amx_int8"}})
    if (has) all += (all.empty() ? "" : ", ") + std::string(name);
  return all.empty() ? "none of those looked for" : all;
}

}  // namespace uwv
