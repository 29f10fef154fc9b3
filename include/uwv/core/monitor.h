// SPDX-License-Identifier: Apache-2.0
// How long work talks to its caller: progress, warnings, and the wish to stop. One object per job, no globals.
#pragma once

#include <string>
#include <string_view>

#include "uwv/core/error.h"

namespace uwv {

/// Handed by the caller to every long computation. The default implementation hears nothing and never stops.
/// Called from the thread that runs the job; implementations that stop on a signal only read a flag.
class Monitor {
 public:
  virtual ~Monitor() = default;

  /// After each step of a stage: `done` of `total` steps (total 0 = unknown). Return false to stop the job.
  virtual bool progress(std::string_view /*stage*/, long /*done*/, long /*total*/) { return true; }
  /// Something the user should know that did not stop the job; the job's summary repeats it.
  virtual void warn(const std::string& /*sentence*/) {}

  /// Reports progress and throws Error(cancelled) when the caller wants to stop.
  void step(std::string_view stage, long done, long total) {
    if (!progress(stage, done, total)) fail(ErrorCode::cancelled, "stopped in stage '{}' after step {}", stage, done);
  }
};

}  // namespace uwv
