// SPDX-License-Identifier: Apache-2.0
#include "io/json_fields.h"

#include <cmath>

#include "io/printable.h"
#include "uwv/core/error.h"

namespace uwv::io {

std::string JsonPlace::where() const { return fmt::format("{}: {}", path, pointer.empty() ? "/" : pointer); }

const JsonPlace& JsonPlace::require_object() const {
  if (!value.is_object()) fail(ErrorCode::value_invalid, "{} must be an object", where());
  return *this;
}

const JsonPlace& JsonPlace::require_array() const {
  if (!value.is_array()) fail(ErrorCode::value_invalid, "{} must be an array", where());
  return *this;
}

bool JsonPlace::has(const char* key) const { return require_object().value.contains(key); }

JsonPlace JsonPlace::at(const char* key) const {
  if (!has(key)) fail(ErrorCode::value_invalid, "{}/{} is missing", where(), key);
  return {value[key], path, fmt::format("{}/{}", pointer, key)};
}

JsonPlace JsonPlace::at(std::size_t index) const {
  require_array();
  if (index >= value.size())
    fail(ErrorCode::value_invalid, "{} has {} elements; number {} is wanted", where(), value.size(), index);
  return {value[index], path, fmt::format("{}/{}", pointer, index)};
}

double JsonPlace::number() const {
  const double number = value.is_number() ? value.get<double>() : std::nan("");
  if (!std::isfinite(number))
    fail(ErrorCode::value_invalid, "{} is {}; a finite number is wanted", where(),
         printable(value.dump()).substr(0, 60));
  return number;
}

int JsonPlace::positive(int max) const {
  const double whole = number();
  if (!(whole >= 1 && whole <= max && whole == std::floor(whole)))
    fail(ErrorCode::value_invalid, "{} is {}; a whole number from 1 to {} is wanted", where(), whole, max);
  return static_cast<int>(whole);
}

std::optional<double> JsonPlace::optional_number(const char* key) const {
  if (!has(key)) return std::nullopt;
  return at(key).number();
}

const std::string& JsonPlace::string() const {
  if (!value.is_string()) fail(ErrorCode::value_invalid, "{} must be a string", where());
  return value.get_ref<const std::string&>();
}

}  // namespace uwv::io
