// SPDX-License-Identifier: Apache-2.0
// Runs a program as a process and keeps what it said.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace uwv::test {

struct Outcome {
  int exit_code = -1;  ///< 128 + signal when a signal ended it.
  std::string out, err;
  long peak_kib = 0;  ///< Largest resident memory.
};

/// A started uwv_app with its output going to files in `folder`, which is also where it runs.
class Program {
 public:
  Program(const std::string& folder, const std::vector<std::string>& arguments);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void signal(int number) const;
  Outcome wait();

 private:
  std::string folder_;
  pid_t process_ = -1;
};

Outcome run_app(const std::string& folder, const std::vector<std::string>& arguments);

}  // namespace uwv::test
