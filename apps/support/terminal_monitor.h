// SPDX-License-Identifier: Apache-2.0
// Progress for people, on stdout: a bar with time left on a terminal, plain lines elsewhere; Ctrl-C asks the job to
// stop.
#pragma once

#include <chrono>
#include <string>

#include "uwv/core/monitor.h"

namespace uwv::app {

class TerminalMonitor : public Monitor {
 public:
  /// From now on SIGINT and SIGTERM ask the job to stop at its next step; the same signal again ends the program.
  TerminalMonitor();
  ~TerminalMonitor() override;

  bool progress(std::string_view stage, long done, long total) override;
  void warn(const std::string& sentence) override;
  /// Ends the line of a bar, if there is one.
  void end_line();

 private:
  using Clock = std::chrono::steady_clock;
  void draw(long done, long total);

  const bool on_terminal_;
  bool line_open_ = false;
  std::string stage_;
  Clock::time_point stage_start_, last_shown_;
};

}  // namespace uwv::app
