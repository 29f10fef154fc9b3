// SPDX-License-Identifier: Apache-2.0
// What a stage cost: wall-clock seconds and the process's peak memory meanwhile.
#pragma once

#include <chrono>
#include <cstdint>

namespace uwv::pipeline {

/// Starts when made.
class StageClock {
 public:
  StageClock();
  double seconds() const;
  /// Largest resident memory of the process since this clock started; where the system cannot restart the count, since
  /// the process did.
  std::uint64_t peak_bytes() const;

 private:
  std::chrono::steady_clock::time_point start_;
};

}  // namespace uwv::pipeline
