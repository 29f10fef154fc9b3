// SPDX-License-Identifier: Apache-2.0
// Another program, run to its end or to the end of our patience.
#pragma once

#include <string>
#include <vector>

namespace uwv::bench {

struct ChildResult {
  bool started = false;
  bool timed_out = false;  ///< It was ended because it took too long.
  int status = -1;         ///< Exit code; -1 = ended by a signal.
  double seconds = 0;
  double processor_seconds = 0;  ///< Of all its threads.
  bool ok() const { return started && !timed_out && status == 0; }
};

/// Runs words[0], found on the PATH, with the other words as arguments; `environment` ("NAME=value") is added to ours.
/// Both its outputs go to the end of the file `log`.
ChildResult run_child(const std::vector<std::string>& words, const std::vector<std::string>& environment,
                      const std::string& log, double patience_seconds);

}  // namespace uwv::bench
