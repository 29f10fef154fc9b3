// SPDX-License-Identifier: Apache-2.0
#include "apps/program.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>

namespace uwv::test {
namespace {

std::string slurp(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// In the child: no allocation between fork and exec.
[[noreturn]] void become(const char* folder, const char* out, const char* err, char* const* arguments) {
  const int out_file = ::open(out, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  const int err_file = ::open(err, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  if (out_file < 0 || err_file < 0 || ::dup2(out_file, STDOUT_FILENO) < 0 || ::dup2(err_file, STDERR_FILENO) < 0 ||
      ::chdir(folder) != 0)
    ::_exit(127);
  ::execv(arguments[0], arguments);
  ::_exit(127);
}

}  // namespace

Program::Program(const std::string& folder, const std::vector<std::string>& arguments) : folder_(folder) {
  std::vector<std::string> words = {UWV_APP};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const std::string out = folder_ + "/.stdout", err = folder_ + "/.stderr";
  ::setenv("LSAN_OPTIONS", "suppressions=" UWV_LEAKS ":print_suppressions=0", 0);
  process_ = ::fork();
  if (process_ == 0) become(folder_.c_str(), out.c_str(), err.c_str(), pointers.data());
}

Program::~Program() {
  if (process_ > 0) {
    signal(SIGKILL);
    wait();
  }
}

void Program::signal(int number) const { ::kill(process_, number); }

Outcome Program::wait() {
  int status = 0;
  rusage usage{};
  ::wait4(process_, &status, 0, &usage);
  process_ = -1;
  Outcome outcome;
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  outcome.out = slurp(folder_ + "/.stdout");
  outcome.err = slurp(folder_ + "/.stderr");
  outcome.peak_kib = usage.ru_maxrss;
  return outcome;
}

Outcome run_app(const std::string& folder, const std::vector<std::string>& arguments) {
  return Program(folder, arguments).wait();
}

}  // namespace uwv::test
