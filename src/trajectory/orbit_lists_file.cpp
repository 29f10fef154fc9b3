// SPDX-License-Identifier: Apache-2.0
#include "trajectory/orbit_lists_file.h"

#include <array>
#include <charconv>
#include <fstream>
#include <iterator>

#include "uwv/trajectory/trajectory_spec.h"

namespace uwv {
namespace {

constexpr std::string_view blanks = " \t\r";

/// Cuts the next word off the front of `line`; empty at its end.
std::string_view next_word(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(blanks), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(blanks));
  line.remove_prefix(word.size());
  return word;
}

std::vector<double> parse_line(std::string_view line, std::string_view name, std::size_t number, detail::Range range) {
  std::vector<double> values;
  for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
    double value = 0;
    const std::string_view digits = word.substr(word.front() == '+' ? 1 : 0);
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size() || !range.holds(value))
      fail(ErrorCode::value_invalid, "{}: line {}, value {} is '{}'; {} is wanted", name, number, values.size() + 1,
           word.substr(0, 40), range.text());
    if (values.size() == detail::most_list_values)
      fail(ErrorCode::value_invalid, "{}: line {} has more than {} values", name, number, detail::most_list_values);
    values.push_back(value);
  }
  return values;
}

}  // namespace

OrbitLists parse_orbit_lists(std::string_view text, std::string_view name) {
  OrbitLists lists;
  const std::array<std::vector<double>*, 3> targets{&lists.phi, &lists.theta, &lists.r};
  std::size_t filled = 0;
  std::size_t number = 0;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    ++number;
    const detail::Range range = filled == 2 ? detail::list_distances : detail::any_angle;
    std::vector<double> values = parse_line(line, name, number, range);
    if (values.empty()) continue;
    if (filled == targets.size())
      fail(ErrorCode::value_invalid,
           "{}: line {} is a fourth line of numbers; the three lines phi, theta, r are wanted", name, number);
    *targets[filled++] = std::move(values);
  }
  if (filled != targets.size())
    fail(ErrorCode::value_invalid, "{}: holds {} lines of numbers; the three lines phi, theta, r are wanted", name,
         filled);
  return lists;
}

namespace detail {

std::string read_text(const std::filesystem::path& path, std::uintmax_t limit) {
  std::error_code problem;
  if (!std::filesystem::is_regular_file(path, problem))
    fail(ErrorCode::file_not_found, "{}: there is no such file", path.string());
  std::ifstream stream(path, std::ios::binary);
  if (!stream) fail(ErrorCode::file_not_found, "{}: cannot be opened for reading", path.string());
  const std::uintmax_t size = std::filesystem::file_size(path, problem);
  if (problem || size > limit)
    fail(ErrorCode::value_invalid, "{}: has {} bytes; a trajectory file of at most {} is wanted", path.string(), size,
         limit);
  return {std::istreambuf_iterator<char>(stream), {}};
}

OrbitLists read_orbit_lists(const std::filesystem::path& path) {
  constexpr std::uintmax_t limit = 1 << 20;
  return parse_orbit_lists(read_text(path, limit), path.string());
}

}  // namespace detail
}  // namespace uwv
