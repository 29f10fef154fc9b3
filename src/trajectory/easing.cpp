// SPDX-License-Identifier: Apache-2.0
#include "uwv/trajectory/easing.h"

#include <algorithm>
#include <array>

namespace uwv {
namespace {

constexpr std::array<std::string_view, 5> names{"linear", "smooth", "in", "out", "in_out"};

}  // namespace

double ease(Easing easing, double t) {
  t = std::clamp(t, 0.0, 1.0);
  switch (easing) {
    case Easing::linear: return t;
    case Easing::smooth: return t * t * t * (10 + t * (6 * t - 15));
    case Easing::in: return t * t;
    case Easing::out: return t * (2 - t);
    case Easing::in_out: return t * t * (3 - 2 * t);
  }
  return t;
}

std::string_view to_string(Easing easing) { return names[static_cast<std::size_t>(easing)]; }

std::optional<Easing> easing_from_string(std::string_view name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<Easing>(found - names.begin());
}

std::span<const std::string_view> easing_names() { return names; }

}  // namespace uwv
