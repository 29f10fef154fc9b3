// SPDX-License-Identifier: Apache-2.0
// The two kinds of failure of this library.
//
// The outside world's failures (a file that lies, a missing key, a full disk) are `uwv::Error`: a code that programs
// can switch on and one sentence for people, naming what was read, what was found, what was wanted and what to change.
// A caller's mistake (sizes that do not match, an option out of range) is `std::invalid_argument` carrying both values;
// it is a bug in the calling program, not something to catch and go on from.
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <string_view>

namespace uwv {

enum class ErrorCode {
  file_not_found,   ///< A named file or folder does not exist or cannot be opened.
  file_damaged,     ///< Its bytes break the rules of its own format: truncated, lying header, impossible size.
  format_unknown,   ///< The file is none of the formats we read.
  value_invalid,    ///< The file is well formed, yet a value in it cannot be used (a singular pose, an unknown preset).
  size_mismatch,    ///< Two inputs do not fit together (depth of another size, fewer cameras than frames).
  output_failed,    ///< Writing failed: permission, disk full, or the output would overwrite an input.
  backend_missing,  ///< This machine lacks what was asked for (no EGL, no H.264 encoder).
  out_of_memory,    ///< The job needs more memory than allowed; the sentence says how much and what shrinks it.
  cancelled,        ///< The monitor asked to stop; nothing half-written was left behind.
};

/// The code's name as written in `run.json`, e.g. "file_damaged".
std::string_view to_string(ErrorCode code);

/// A failure of the outside world. `what()` is one sentence without a line break.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& sentence) : std::runtime_error(sentence), code_(code) {}
  ErrorCode code() const noexcept { return code_; }

 private:
  ErrorCode code_;
};

/// Throws `Error` with a formatted sentence: fail(ErrorCode::file_damaged, "{}: header says {} bytes, ...", path, n).
template <class... Args>
[[noreturn]] void fail(ErrorCode code, fmt::format_string<Args...> format, Args&&... args) {
  throw Error(code, fmt::format(format, std::forward<Args>(args)...));
}

/// Throws std::invalid_argument with a formatted sentence unless `condition` holds: for the caller's mistakes only.
template <class... Args>
void require(bool condition, fmt::format_string<Args...> format, Args&&... args) {
  if (!condition) throw std::invalid_argument(fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace uwv
