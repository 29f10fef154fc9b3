// SPDX-License-Identifier: Apache-2.0
// The devices libtorch offers, found without a word of CUDA's: the same code is built against any libtorch.
#pragma once

#include <c10/core/Device.h>

#include <optional>
#include <string>

namespace uwv::model {

/// The device of a name such as "cpu", "cuda" (the first one) or "cuda:1", made ready for use. Throws
/// Error(value_invalid) for what is no name of a device, Error(backend_missing) listing what is at hand when it is not
/// there or does not work.
c10::Device compute_device(const std::string& name);

/// Bytes nobody uses of the device's own memory; nothing where libtorch does not tell, and for the CPU.
std::optional<std::uint64_t> free_bytes(c10::Device device);

}  // namespace uwv::model
