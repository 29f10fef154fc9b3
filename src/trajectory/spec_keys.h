// SPDX-License-Identifier: Apache-2.0
// Names shared by the reader and the writer of trajectory files.
#pragma once

#include <array>
#include <string_view>

namespace uwv::detail {

inline constexpr std::array<std::string_view, 2> frame_of_reference_names{"subject", "source_world"};
inline constexpr std::array<std::string_view, 2> unit_names{"scene", "radius"};
/// The keys of which a file has exactly one.
inline constexpr std::array<std::string_view, 6> motion_keys{"preset", "orbit", "free", "txt", "keyframes", "cameras"};

}  // namespace uwv::detail
