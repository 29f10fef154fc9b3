// SPDX-License-Identifier: Apache-2.0
// How a movement starts and ends.
#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace uwv {

enum class Easing {
  linear,  ///< Constant speed.
  smooth,  ///< Starts and ends at rest, without a jump of the acceleration (6t^5 - 15t^4 + 10t^3).
  in,      ///< Starts at rest, ends at full speed (t^2).
  out,     ///< Starts at full speed, ends at rest (1 - (1-t)^2).
  in_out,  ///< Starts and ends at rest (3t^2 - 2t^3).
};

/// Maps [0, 1] onto [0, 1], monotonically, with ease(., 0) = 0 and ease(., 1) = 1. `t` outside is clamped.
double ease(Easing easing, double t);

std::string_view to_string(Easing easing);
std::optional<Easing> easing_from_string(std::string_view name);
/// All names, in the enum's order.
std::span<const std::string_view> easing_names();

}  // namespace uwv
