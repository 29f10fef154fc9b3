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

/// By the processor's units; where those do not tell (AVX-512's for bfloat16 were half as fast as float32 on a
/// processor we measured) both are tried, once a process, for a moment. Where the two are about as fast, the answer may
/// differ from process to process, and with it the last digits of what WeightsForm::automatic and int8 give.
FastNumbers fast_numbers();

}  // namespace uwv
