// SPDX-License-Identifier: Apache-2.0
// Short names for bytes: what tells a finished stage apart from one made of other inputs or options.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace uwv::pipeline {

/// SHA-256 in hexadecimal.
std::string sha256(std::string_view bytes);

/// What identifies an input: {"bytes", "modified" (nanoseconds since 1970), "files", "sha256"}. The hash covers the
/// first and last 64 KiB of a file, so that long videos cost nothing; of a folder or pattern, the names, sizes and
/// times of the files beside it. An input that does not exist gives null.
nlohmann::ordered_json input_identity(const std::string& path);

/// The same for a checkpoint: of a folder, the files in the folders below it count as well.
nlohmann::ordered_json checkpoint_identity(const std::string& path);

}  // namespace uwv::pipeline
