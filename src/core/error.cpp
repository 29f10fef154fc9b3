// SPDX-License-Identifier: Apache-2.0
#include "uwv/core/error.h"

namespace uwv {

std::string_view to_string(ErrorCode code) {
  switch (code) {
    case ErrorCode::file_not_found: return "file_not_found";
    case ErrorCode::file_damaged: return "file_damaged";
    case ErrorCode::format_unknown: return "format_unknown";
    case ErrorCode::value_invalid: return "value_invalid";
    case ErrorCode::size_mismatch: return "size_mismatch";
    case ErrorCode::output_failed: return "output_failed";
    case ErrorCode::backend_missing: return "backend_missing";
    case ErrorCode::out_of_memory: return "out_of_memory";
    case ErrorCode::cancelled: return "cancelled";
  }
  return "unknown";
}

}  // namespace uwv
