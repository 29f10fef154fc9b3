// SPDX-License-Identifier: Apache-2.0
#include "pipeline/resources.h"

#include "uwv/core/peak_memory.h"

namespace uwv::pipeline {

StageClock::StageClock() : start_(std::chrono::steady_clock::now()) { restart_peak_memory(); }

double StageClock::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

std::uint64_t StageClock::peak_bytes() const { return peak_memory(); }

}  // namespace uwv::pipeline
