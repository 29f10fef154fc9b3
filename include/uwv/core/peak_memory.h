// SPDX-License-Identifier: Apache-2.0
// The most memory this process has held.
#pragma once

#include <cstdint>

namespace uwv {

/// Counts anew from now on, where the system lets it (Linux).
void restart_peak_memory();

/// Bytes resident at the largest since then, or since the process began; mapped files that were read included.
std::uint64_t peak_memory();

}  // namespace uwv
