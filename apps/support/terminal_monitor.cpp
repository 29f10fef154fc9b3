// SPDX-License-Identifier: Apache-2.0
#include "support/terminal_monitor.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace uwv::app {
namespace {

volatile sig_atomic_t stop_wanted = 0;  // a signal handler can reach nothing else

void remember_signal(int) { stop_wanted = 1; }

void handle(int signal) {
  struct sigaction action {};
  action.sa_handler = remember_signal;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigaction(signal, &action, nullptr);
}

std::string minutes(double seconds) {
  const long whole = static_cast<long>(std::max(0.0, seconds) + 0.5);
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

}  // namespace

TerminalMonitor::TerminalMonitor() : on_terminal_(::isatty(STDOUT_FILENO) != 0) {
  handle(SIGINT);
  handle(SIGTERM);
}

TerminalMonitor::~TerminalMonitor() { end_line(); }

bool TerminalMonitor::progress(std::string_view stage, long done, long total) {
  const auto now = Clock::now();
  const bool starts = stage != stage_;
  if (starts) {
    end_line();
    stage_ = stage;
    stage_start_ = now;
  }
  // A line every few seconds is news in a log; a bar moves smoothly at ten frames a second.
  const auto interval = on_terminal_ ? std::chrono::milliseconds(100) : std::chrono::milliseconds(5000);
  if (starts || now - last_shown_ >= interval || (done == total && total > 0)) {
    last_shown_ = now;
    draw(done, total);
  }
  return stop_wanted == 0;
}

void TerminalMonitor::draw(long done, long total) {
  const double seconds = std::chrono::duration<double>(Clock::now() - stage_start_).count();
  std::string left;
  if (done > 0 && total > done && seconds > 0.5)
    left = "  " + minutes(seconds / static_cast<double>(done) * static_cast<double>(total - done)) + " left";
  if (!on_terminal_) {
    fmt::print(stdout, "{}: {}/{}{}\n", stage_, done, total, left);
    return;
  }
  constexpr long width = 30;
  const long filled = total > 0 ? std::min(width, done * width / total) : 0;
  fmt::print(stdout, "\r{:<13} [{:#<{}}{:.<{}}] {}/{}{}\033[K", stage_, "", filled, "", width - filled, done, total,
             left);
  std::fflush(stdout);
  line_open_ = true;
}

void TerminalMonitor::warn(const std::string& sentence) {
  end_line();
  fmt::print(stdout, "warning: {}\n", sentence);
}

void TerminalMonitor::end_line() {
  if (line_open_) fmt::print(stdout, "\n");
  line_open_ = false;
}

}  // namespace uwv::app
