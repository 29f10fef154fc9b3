// SPDX-License-Identifier: Apache-2.0
// Trajectory texts: three lines of numbers.
#pragma once

#include <filesystem>

#include "trajectory/json_node.h"
#include "uwv/trajectory/orbit.h"

namespace uwv::detail {

/// Known files have up to 25; the smoothing's cost grows with the square.
inline constexpr std::size_t most_list_values = 1000;
/// Shares of the radius added to the distance: the camera stays in front of the subject.
inline constexpr Range list_distances{-0.999, 1e6};

/// The bytes of a file of at most `limit` bytes. Throws Error(file_not_found), or Error(value_invalid) when it is
/// larger.
std::string read_text(const std::filesystem::path& path, std::uintmax_t limit);

OrbitLists read_orbit_lists(const std::filesystem::path& path);

}  // namespace uwv::detail
