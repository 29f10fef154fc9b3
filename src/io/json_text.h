// SPDX-License-Identifier: Apache-2.0
// JSON from outside, parsed with the checks that the parser itself leaves out.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace uwv::io {

/// Parses JSON text. Throws Error(file_damaged) naming `path` for syntax errors, for a key that occurs twice in one
/// object, and for nesting deeper than 32 levels.
nlohmann::json parse_json(std::string_view text, const std::string& path);

}  // namespace uwv::io
