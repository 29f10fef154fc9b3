// SPDX-License-Identifier: Apache-2.0
// A device that stands for a GPU where there is none: memory the CPU cannot reach by its address, operators that refuse
// tensors from elsewhere. It computes by copying to the CPU and back, so that its answers are the CPU's.
//
// What would go wrong on a GPU goes wrong here: a table left on the CPU throws, a pointer read directly ends the
// program. Linking far_device.cpp makes the device known to libtorch.
#pragma once

#include <c10/core/Device.h>

#include <cstdint>

namespace uwv::testing {

/// As --device takes it.
inline constexpr const char* far_device_name = "privateuseone";
inline const c10::Device far_device{c10::DeviceType::PrivateUse1, 0};

/// Operators it has run so far, to see that it was used at all.
std::int64_t far_operators();

}  // namespace uwv::testing
