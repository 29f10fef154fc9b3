// SPDX-License-Identifier: Apache-2.0
// The most memory this program has held since it was last asked to count anew.
#pragma once

#include <fstream>
#include <string>

namespace uwv::bench {

inline void restart_peak_memory() { std::ofstream("/proc/self/clear_refs") << "5"; }

/// Bytes, mapped files that were read included; 0 where the system doesn't tell.
inline double peak_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) * 1024;
  return 0;
}

}  // namespace uwv::bench
