// SPDX-License-Identifier: Apache-2.0
#include "model/text/html_text.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <optional>

#include "model/text/utf8.h"
#include "model/text/windows_1252.h"

namespace uwv::model {
namespace {

#include "model/text/html_entities.inc"

constexpr std::size_t max_name = 32;  // the longest name with its semicolon

using Names = std::map<std::string, std::string, std::less<>>;

const Names& names() {
  static const Names table = [] {
    Names made;
    for (std::string_view rest = html_entities; !rest.empty();) {
      const auto middle = rest.find('\1'), end = rest.find('\2');
      made.emplace(rest.substr(0, middle), rest.substr(middle + 1, end - middle - 1));
      rest.remove_prefix(end + 1);
    }
    return made;
  }();
  return table;
}

char capital(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

std::string in_capitals(std::string_view name) {
  std::string capitals(name);
  std::transform(name.begin(), name.end(), capitals.begin(), capital);
  return capitals;
}

/// Names that mean nothing in capitals, given the capital of what they mean. Only Latin-1 letters have such names.
const Names& capital_names() {
  static const Names table = [] {
    Names made;
    for (const auto& [name, text] : names()) {
      const std::string capitals = in_capitals(name);
      if (!name.ends_with(';') || capitals == name || name.find_first_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ") != name.npos)
        continue;
      // Neither the name in capitals nor any beginning of it may mean something.
      bool free = true;
      for (std::size_t n = 2; n <= capitals.size(); ++n) free = free && !names().contains(capitals.substr(0, n));
      if (free) made.emplace(capitals, capital_letters(text));
    }
    return made;
  }();
  return table;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_hex(char c) { return is_digit(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F'); }
bool is_ascii_alphanumeric(char c) { return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/// A reference: the bytes after the '&' it takes, and what it stands for.
struct Reference {
  std::size_t bytes = 0;
  std::string text;
};

/// What HTML5 reads a number as; many do not stand for a character.
std::string character_of(std::uint32_t number) {
  if (number == 0 || number > 0x10FFFF || (number >= 0xD800 && number <= 0xDFFF)) return encode_utf8(U"\uFFFD");
  const bool unwanted = (number < 0x20 && number != 9 && number != 10 && number != 12 && number != 13) ||
                        number == 0x7F || (number >= 0xFDD0 && number <= 0xFDEF) || (number & 0xFFFE) == 0xFFFE;
  if (unwanted) return "";
  if (number >= 0x80 && number < 0xA0) return encode_utf8(std::u32string(1, from_windows_1252(number)));
  return encode_utf8(std::u32string(1, number));
}

std::optional<Reference> numeric(std::string_view rest) {
  const bool hex = rest.size() > 1 && (rest[1] == 'x' || rest[1] == 'X');
  std::size_t at = hex ? 2 : 1;
  const std::size_t digits = at;
  std::uint32_t number = 0;
  for (; at < rest.size() && (hex ? is_hex(rest[at]) : is_digit(rest[at])); ++at) {
    const auto digit = static_cast<std::uint32_t>(is_digit(rest[at]) ? rest[at] - '0' : capital(rest[at]) - 'A' + 10);
    number = std::min<std::uint32_t>(number * (hex ? 16 : 10) + digit, 0x110000);
  }
  if (at == digits) return std::nullopt;
  const bool closed = at < rest.size() && rest[at] == ';';
  return Reference{at + (closed ? 1 : 0), character_of(number)};
}

/// The longest name that `rest` begins with.
std::optional<Reference> named(std::string_view rest) {
  const std::size_t end = std::min(rest.find_first_of("\t\n\f <&#;"), std::min(rest.size(), max_name));
  const bool closed = end < rest.size() && rest[end] == ';';
  for (std::size_t bytes = end + (closed ? 1 : 0); bytes > 1; --bytes)
    if (const auto found = names().find(rest.substr(0, bytes)); found != names().end())
      return Reference{bytes, found->second};
  return std::nullopt;
}

std::optional<Reference> closed_reference(std::string_view rest) {
  constexpr std::size_t max_inside = 24;
  const std::size_t begin = rest.starts_with('#') ? 1 : 0;
  std::size_t end = begin;
  while (end < rest.size() && end - begin < max_inside && is_ascii_alphanumeric(rest[end])) ++end;
  if (end == begin || end == rest.size() || rest[end] != ';') return std::nullopt;
  if (begin == 1) {
    auto found = numeric(rest);
    return found && found->bytes == end + 1 ? found : std::nullopt;
  }
  const std::string_view name = rest.substr(0, end + 1);
  for (const Names* table : {&names(), &capital_names()})
    if (const auto found = table->find(name); found != table->end()) return Reference{name.size(), found->second};
  return std::nullopt;
}

}  // namespace

std::string unescape_html(std::string_view text, HtmlReferences references) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t next = std::min(text.find('&', at), text.size());
    out += text.substr(at, next - at);
    if (next == text.size()) break;
    const std::string_view rest = text.substr(next + 1);
    const auto found = references == HtmlReferences::closed ? closed_reference(rest)
                       : rest.starts_with('#')              ? numeric(rest)
                                                            : named(rest);
    out += found ? found->text : "&";
    at = next + 1 + (found ? found->bytes : 0);
  }
  return out;
}

}  // namespace uwv::model
