// SPDX-License-Identifier: Apache-2.0
// Rows of named figures, printed as an aligned table and written as JSON.
#pragma once

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace uwv::bench {

/// A number for a row. JSON has no NaN: what cannot be judged is a dash.
nlohmann::ordered_json figure(double value);

class Table {
 public:
  Table(std::string name, std::vector<std::string> columns) : name_(std::move(name)), columns_(std::move(columns)) {}

  /// One value per column: text, or a number with the digits to print.
  void add(const std::vector<nlohmann::ordered_json>& values);
  /// To standard output, numbers with three significant digits.
  void print() const;
  /// An array of objects, one a row.
  nlohmann::ordered_json json() const;
  const std::string& name() const { return name_; }

 private:
  std::string name_;
  std::vector<std::string> columns_;
  std::vector<std::vector<nlohmann::ordered_json>> rows_;
};

}  // namespace uwv::bench
