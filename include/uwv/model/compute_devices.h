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

}  // namespace uwv
