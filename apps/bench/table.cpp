// SPDX-License-Identifier: Apache-2.0
#include "bench/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "uwv/core/error.h"

namespace uwv::bench {
namespace {

std::string text_of(const nlohmann::ordered_json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return fmt::format("{:.4g}", value.get<double>());
  return value.dump();
}

}  // namespace

nlohmann::ordered_json figure(double value) {
  if (std::isfinite(value)) return value;
  return "-";
}

void Table::add(const std::vector<nlohmann::ordered_json>& values) {
  require(values.size() == columns_.size(), "table '{}' has {} columns, the row {}", name_, columns_.size(),
          values.size());
  rows_.push_back(values);
}

void Table::print() const {
  std::vector<std::size_t> widths;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    widths.push_back(columns_[c].size());
    for (const auto& row : rows_) widths[c] = std::max(widths[c], text_of(row[c]).size());
  }
  fmt::print("\n{}\n", name_);
  for (std::size_t c = 0; c < columns_.size(); ++c) fmt::print("{:<{}}  ", columns_[c], widths[c]);
  fmt::print("\n");
  for (const auto& row : rows_) {
    for (std::size_t c = 0; c < columns_.size(); ++c)
      if (row[c].is_string())
        fmt::print("{:<{}}  ", text_of(row[c]), widths[c]);
      else
        fmt::print("{:>{}}  ", text_of(row[c]), widths[c]);
    fmt::print("\n");
  }
}

nlohmann::ordered_json Table::json() const {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const auto& row : rows_) {
    nlohmann::ordered_json object;
    for (std::size_t c = 0; c < columns_.size(); ++c) object[columns_[c]] = row[c];
    rows.push_back(object);
  }
  return rows;
}

}  // namespace uwv::bench
