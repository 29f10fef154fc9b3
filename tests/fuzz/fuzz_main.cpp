// SPDX-License-Identifier: Apache-2.0
// The entry of libFuzzer. UWV_FUZZ_INPUT names one of the functions of fuzz_inputs.h.
#include <cstddef>
#include <cstdint>

#include "fuzz/fuzz_inputs.h"
#include "uwv/core/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    uwv::testing::UWV_FUZZ_INPUT({reinterpret_cast<const char*>(data), size});
  } catch (const uwv::Error&) {
    // How readers refuse; any other exception ends the program and is a finding.
  }
  return 0;
}
