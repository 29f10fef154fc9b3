// SPDX-License-Identifier: Apache-2.0
#include "io/json_text.h"

#include <set>
#include <vector>

#include "uwv/core/error.h"

namespace uwv::io {
namespace {

/// The parser's own words carry line breaks and an identifier in brackets; ours is one sentence.
std::string one_line(std::string_view words) {
  if (const auto bracket = words.find("] "); bracket != std::string_view::npos) words.remove_prefix(bracket + 2);
  std::string line(words.substr(0, 200));
  for (char& c : line)
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  return line;
}

}  // namespace

nlohmann::json parse_json(std::string_view text, const std::string& path) {
  using nlohmann::json;
  constexpr int max_nesting = 32;
  std::vector<std::set<std::string>> keys_of_open_objects;
  const auto check = [&](int depth, json::parse_event_t event, json& parsed) {
    if (depth > max_nesting) fail(ErrorCode::file_damaged, "{}: its JSON nests deeper than {}", path, max_nesting);
    if (event == json::parse_event_t::object_start) keys_of_open_objects.emplace_back();
    if (event == json::parse_event_t::object_end) keys_of_open_objects.pop_back();
    if (event == json::parse_event_t::key) {
      const auto& key = parsed.get_ref<const std::string&>();
      if (!keys_of_open_objects.back().insert(key).second)
        fail(ErrorCode::file_damaged, "{}: its JSON has the key '{}' twice in one object", path, key.substr(0, 100));
    }
    return true;
  };
  try {
    return json::parse(text.begin(), text.end(), check);
  } catch (const json::exception& error) {
    fail(ErrorCode::file_damaged, "{}: is not valid JSON: {}", path, one_line(error.what()));
  }
}

}  // namespace uwv::io
