// SPDX-License-Identifier: Apache-2.0
#include "pipeline/resources.h"

#include <sys/resource.h>

#include <fstream>
#include <string>

namespace uwv::pipeline {

StageClock::StageClock() : start_(std::chrono::steady_clock::now()) {
  std::ofstream("/proc/self/clear_refs") << 5;  // Linux: resets VmHWM (proc(5))
}

double StageClock::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

std::uint64_t StageClock::peak_bytes() const {
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

}  // namespace uwv::pipeline
