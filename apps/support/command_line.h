// SPDX-License-Identifier: Apache-2.0
// The command line made from the option table, and the exit codes of every program here.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "uwv/pipeline/option_table.h"

namespace uwv::app {

/// 0 = done, 1 = a bug of ours, 2 = bad input or usage, 130 = interrupted.
enum ExitCode { exit_done = 0, exit_bug = 1, exit_bad_input = 2, exit_interrupted = 130 };

/// Adds every option of a run to a command, grouped, each with its default in the help, and --options to start from an
/// earlier run's run.json.
class RunFlags {
 public:
  using Filter = std::function<bool(const OptionInfo&)>;
  /// Only the options that `wanted` lets through; empty = all.
  explicit RunFlags(CLI::App& command, const Filter& wanted = {});
  RunFlags(const RunFlags&) = delete;
  RunFlags& operator=(const RunFlags&) = delete;

  /// After parsing: the file's options (or the defaults) with what was typed on top, checked.
  RunOptions options() const;
  /// The same, not checked as a whole: for commands that need only some of them.
  RunOptions some_options() const;

 private:
  std::string options_file_;
  std::vector<std::pair<std::string, std::string>> typed_;
};

/// Parses and answers --help and --version. True when the program goes on; else `exit_code` is set and everything said.
bool parse(CLI::App& app, int argc, char** argv, int& exit_code);

/// Runs `body` and turns what it throws into one line on stderr and an exit code.
int guarded(const std::function<void()>& body);

}  // namespace uwv::app
