// SPDX-License-Identifier: Apache-2.0
// A value inside a trajectory file that knows its JSON pointer, so that every complaint can say where.
#pragma once

#include <Eigen/Core>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace uwv::detail {

/// A closed range of acceptable numbers; `above` and `below` make an end open.
struct Range {
  double least;
  double most;
  bool above = false;
  bool below = false;
  bool holds(double value) const;
  std::string text() const;
};

/// Positions, distances and focal lengths: anything larger loses millimetres even in double.
inline constexpr Range any_length{-1e15, 1e15};
inline constexpr Range positive_length{0, 1e15, true};
/// Degrees. A thousand turns are a mistake, not a wish.
inline constexpr Range any_angle{-360000, 360000};

class JsonNode {
 public:
  JsonNode(const nlohmann::json& value, std::string pointer, const std::string& name)
      : value_(&value), pointer_(std::move(pointer)), name_(&name) {}

  const nlohmann::json& value() const { return *value_; }
  /// "<name>: <pointer>", for complaints made elsewhere.
  std::string place() const;
  /// Throws Error(value_invalid): "<name>: <pointer> is <what it is>; <wanted> is wanted".
  [[noreturn]] void refuse(std::string_view wanted) const;
  /// Throws Error(value_invalid): "<name>: <pointer>: <sentence>".
  [[noreturn]] void complain(std::string_view sentence) const;

  /// An object without other keys than these.
  void check_keys(std::span<const std::string_view> known) const;
  void check_keys(std::initializer_list<std::string_view> known) const {
    check_keys(std::span<const std::string_view>(known.begin(), known.size()));
  }
  bool has(std::string_view key) const;
  /// The keys among these that are present.
  std::vector<std::string_view> present(std::span<const std::string_view> keys) const;
  /// A member that must be there.
  JsonNode operator[](std::string_view key) const;
  /// The elements of an array of `least` to `most`.
  std::vector<JsonNode> elements(std::size_t least, std::size_t most, std::string_view wanted) const;

  double number(Range range) const;
  long integer(long least, long most) const;
  bool boolean() const;
  /// A string; one of `choices` when there are any, else the nearest one is suggested.
  std::string text(std::span<const std::string_view> choices = {}) const;
  Eigen::Vector3d point() const;
  std::vector<double> numbers(std::size_t least, std::size_t most, Range range) const;
  /// 16 numbers row by row, or four rows of four.
  Eigen::Matrix4d matrix4() const;

  double number_or(std::string_view key, double otherwise, Range range) const {
    return has(key) ? (*this)[key].number(range) : otherwise;
  }

 private:
  const nlohmann::json* value_;
  std::string pointer_;
  const std::string* name_;
};

/// The name among `names` with the fewest edits to `word`, or nothing when none is near.
std::string_view nearest_name(std::string_view word, std::span<const std::string_view> names);
/// "a, b, c".
std::string joined(std::span<const std::string_view> names);

}  // namespace uwv::detail
