// SPDX-License-Identifier: Apache-2.0
#include "trajectory/json_node.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "uwv/core/error.h"

namespace uwv::detail {
namespace {

using nlohmann::json;

std::string shortened(std::string text) {
  constexpr std::size_t longest = 60;
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  return text.size() > longest ? text.substr(0, longest) + "..." : text;
}

/// How a value is named in a complaint: numbers and words as they stand, the rest by kind and size.
std::string described(const json& value) {
  if (value.is_object()) return value.empty() ? "an empty object" : "an object";
  if (value.is_array()) return fmt::format("an array of {}", value.size());
  return shortened(value.dump(-1, ' ', true, json::error_handler_t::replace));
}

/// '~' and '/' inside a key are written ~0 and ~1 (RFC 6901).
std::string escaped(std::string_view key) {
  std::string text;
  for (const char c : key) text += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  return text;
}

std::size_t edits_between(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

bool Range::holds(double value) const {
  return (above ? value > least : value >= least) && (below ? value < most : value <= most);  // false for NaN
}

std::string Range::text() const {
  return fmt::format("a number in {}{:g}, {:g}{}", above ? '(' : '[', least, most, below ? ')' : ']');
}

std::string_view nearest_name(std::string_view word, std::span<const std::string_view> names) {
  word = word.substr(0, 64);
  std::string_view nearest;
  std::size_t fewest = std::max<std::size_t>(2, word.size() / 2) + 1;
  for (const std::string_view name : names) {
    const std::size_t edits = edits_between(word, name);
    if (edits >= fewest) continue;
    fewest = edits;
    nearest = name;
  }
  return nearest;
}

std::string joined(std::span<const std::string_view> names) { return fmt::format("{}", fmt::join(names, ", ")); }

std::string JsonNode::place() const { return fmt::format("{}: {}", *name_, pointer_.empty() ? "the file" : pointer_); }

void JsonNode::refuse(std::string_view wanted) const {
  fail(ErrorCode::value_invalid, "{} is {}; {} is wanted", place(), described(*value_), wanted);
}

void JsonNode::complain(std::string_view sentence) const {
  fail(ErrorCode::value_invalid, "{}: {}", place(), sentence);
}

void JsonNode::check_keys(std::span<const std::string_view> known) const {
  if (!value_->is_object()) refuse(fmt::format("an object with keys among {}", joined(known)));
  for (const auto& [key, unused] : value_->items()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const std::string_view nearest = nearest_name(key, known);
    fail(ErrorCode::value_invalid, "{}: {}/{} is not a known key{}; one of {} is wanted", *name_, pointer_,
         shortened(escaped(key)), nearest.empty() ? "" : fmt::format(" (did you mean '{}'?)", nearest), joined(known));
  }
}

bool JsonNode::has(std::string_view key) const { return value_->is_object() && value_->contains(std::string(key)); }

std::vector<std::string_view> JsonNode::present(std::span<const std::string_view> keys) const {
  std::vector<std::string_view> found;
  std::copy_if(keys.begin(), keys.end(), std::back_inserter(found), [&](std::string_view key) { return has(key); });
  return found;
}

JsonNode JsonNode::operator[](std::string_view key) const {
  if (!has(key)) complain(fmt::format("the key '{}' is missing", key));
  return {(*value_)[std::string(key)], fmt::format("{}/{}", pointer_, escaped(key)), *name_};
}

std::vector<JsonNode> JsonNode::elements(std::size_t least, std::size_t most, std::string_view wanted) const {
  if (!value_->is_array() || value_->size() < least || value_->size() > most) refuse(wanted);
  std::vector<JsonNode> nodes;
  nodes.reserve(value_->size());
  for (std::size_t i = 0; i < value_->size(); ++i)
    nodes.emplace_back((*value_)[i], fmt::format("{}/{}", pointer_, i), *name_);
  return nodes;
}

double JsonNode::number(Range range) const {
  if (!value_->is_number()) refuse(range.text());
  const double number = value_->get<double>();
  if (!range.holds(number)) refuse(range.text());
  return number;
}

long JsonNode::integer(long least, long most) const {
  const auto wanted = [&] { return fmt::format("a whole number from {} to {}", least, most); };
  if (!value_->is_number()) refuse(wanted());
  const double number = value_->get<double>();
  if (!(number >= static_cast<double>(least) && number <= static_cast<double>(most)) || number != std::floor(number))
    refuse(wanted());
  return static_cast<long>(number);
}

bool JsonNode::boolean() const {
  if (!value_->is_boolean()) refuse("true or false");
  return value_->get<bool>();
}

std::string JsonNode::text(std::span<const std::string_view> choices) const {
  const auto wanted = [&] { return choices.empty() ? std::string("a text") : "one of " + joined(choices); };
  if (!value_->is_string()) refuse(wanted());
  const std::string text = value_->get<std::string>();
  if (choices.empty() || std::find(choices.begin(), choices.end(), text) != choices.end()) return text;
  const std::string_view nearest = nearest_name(text, choices);
  refuse(nearest.empty() ? wanted() : fmt::format("{} (did you mean '{}'?)", wanted(), nearest));
}

Eigen::Vector3d JsonNode::point() const {
  const auto values = numbers(3, 3, any_length);
  return Eigen::Vector3d(values[0], values[1], values[2]);
}

std::vector<double> JsonNode::numbers(std::size_t least, std::size_t most, Range range) const {
  const std::string wanted = least == most ? fmt::format("an array of {} numbers", least)
                                           : fmt::format("an array of {} to {} numbers", least, most);
  std::vector<double> values;
  for (const JsonNode& node : elements(least, most, wanted)) values.push_back(node.number(range));
  return values;
}

Eigen::Matrix4d JsonNode::matrix4() const {
  std::vector<double> values;
  if (value_->is_array() && value_->size() == 4) {
    for (const JsonNode& row : elements(4, 4, "four rows")) {
      const auto numbers_of_row = row.numbers(4, 4, any_length);
      values.insert(values.end(), numbers_of_row.begin(), numbers_of_row.end());
    }
  } else {
    values = numbers(16, 16, any_length);
  }
  return Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(values.data());
}

}  // namespace uwv::detail
