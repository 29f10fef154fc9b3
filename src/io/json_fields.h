// SPDX-License-Identifier: Apache-2.0
// Typed access to JSON from outside; every complaint names the file and the JSON pointer.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace uwv::io {

/// A value inside a JSON file and the way to it.
struct JsonPlace {
  const nlohmann::json& value;
  std::string path;     ///< The file.
  std::string pointer;  ///< e.g. "/frames/3/fx"

  std::string where() const;
  /// Throws Error(value_invalid) unless this is an object, an array.
  const JsonPlace& require_object() const;
  const JsonPlace& require_array() const;
  bool has(const char* key) const;
  /// The member of an object; Error(value_invalid) when it is missing.
  JsonPlace at(const char* key) const;
  /// The element of an array.
  JsonPlace at(std::size_t index) const;
  /// A finite number.
  double number() const;
  /// A whole number from 1 to `max`.
  int positive(int max) const;
  /// The number of a member that may be missing.
  std::optional<double> optional_number(const char* key) const;
  const std::string& string() const;
};

}  // namespace uwv::io
