// SPDX-License-Identifier: Apache-2.0
#include "uwv/core/peak_memory.h"

#include <sys/resource.h>

#include <fstream>
#include <string>

namespace uwv {

void restart_peak_memory() {
  std::ofstream("/proc/self/clear_refs") << 5;  // Linux: resets VmHWM (proc(5))
}

std::uint64_t peak_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;)
    if (word == "VmHWM:") {
      std::uint64_t kibibytes = 0;
      status >> kibibytes;
      return kibibytes * 1024;
    }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace uwv
