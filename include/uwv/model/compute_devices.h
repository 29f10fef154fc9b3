// SPDX-License-Identifier: Apache-2.0
// Where the networks can be run: the CPU, and what else the libtorch at hand was built for and finds. This header needs
// no libtorch; the functions are in the component uwv::model.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace uwv {

struct ComputeDevice {
  std::string name;                         ///< As --device takes it: "cpu", "cuda:0".
  std::optional<std::uint64_t> free_bytes;  ///< Of its own memory; unset where libtorch does not tell, and of the CPU.
};

/// The CPU first.
std::vector<ComputeDevice> compute_devices();

/// Which numbers of fewer bits the CPU multiplies faster than float32.
struct FastNumbers {
  bool bf16 = false, int8 = false;
};

/// By the processor's units; where those do not tell (bfloat16 in AVX-512's vectors is twice as fast as float32 on some
/// processors and slower on others) both are tried once, for some tenth of a second.
FastNumbers fast_numbers();

}  // namespace uwv
