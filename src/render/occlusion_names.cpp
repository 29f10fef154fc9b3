// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <utility>

#include "uwv/render/occlusion.h"

namespace uwv {
namespace {

template <class Enum, std::size_t N>
using Names = std::array<std::pair<Enum, std::string_view>, N>;

constexpr Names<Kernel, 3> kernel_names{
    {{Kernel::nearest, "nearest"}, {Kernel::bilinear, "bilinear"}, {Kernel::resample, "resample"}}};
constexpr Names<Visibility, 3> visibility_names{
    {{Visibility::none, "none"}, {Visibility::ztest, "ztest"}, {Visibility::reproject, "reproject"}}};
constexpr Names<Accumulation, 4> accumulation_names{{{Accumulation::product, "product"},
                                                     {Accumulation::product_in_view, "product_in_view"},
                                                     {Accumulation::none, "none"},
                                                     {Accumulation::foreground, "foreground"}}};

template <class Enum, std::size_t N>
std::string_view name_of(const Names<Enum, N>& names, Enum value) {
  for (const auto& [known, name] : names)
    if (known == value) return name;
  return "unknown";
}

template <class Enum, std::size_t N>
Enum value_of(const Names<Enum, N>& names, std::string_view option, std::string_view wanted) {
  std::string list;
  for (const auto& [value, name] : names) {
    if (name == wanted) return value;
    list += (list.empty() ? "" : ", ") + std::string(name);
  }
  fail(ErrorCode::value_invalid, "{} '{}' is unknown; choose one of: {}", option, wanted, list);
}

}  // namespace

std::string_view to_string(Kernel value) { return name_of(kernel_names, value); }
std::string_view to_string(Visibility value) { return name_of(visibility_names, value); }
std::string_view to_string(Accumulation value) { return name_of(accumulation_names, value); }
Kernel parse_kernel(std::string_view name) { return value_of(kernel_names, "kernel", name); }
Visibility parse_visibility(std::string_view name) { return value_of(visibility_names, "visibility", name); }
Accumulation parse_accumulation(std::string_view name) { return value_of(accumulation_names, "accumulation", name); }

}  // namespace uwv
