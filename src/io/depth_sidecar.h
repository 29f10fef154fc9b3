// SPDX-License-Identifier: Apache-2.0
// depth.json, which lies beside 16-bit PNG depths and says what one step means.
#pragma once

#include <optional>
#include <string>

namespace uwv::io {

inline constexpr const char* depth_sidecar_name = "depth.json";

/// The scale stated in the folder's depth.json; nothing when there is no such file. Throws Error when it is damaged or
/// not ours.
std::optional<double> read_depth_sidecar(const std::string& folder);

void write_depth_sidecar(const std::string& folder, double scale, long frames);

}  // namespace uwv::io
