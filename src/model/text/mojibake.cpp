// SPDX-License-Identifier: Apache-2.0
#include "model/text/mojibake.h"

#include <algorithm>
#include <functional>
#include <optional>

#include "model/text/utf8.h"
#include "model/text/windows_1252.h"

namespace uwv::model {
namespace {

using ToByte = std::function<std::optional<unsigned char>(char32_t)>;

std::optional<unsigned char> to_latin_1(char32_t c) {
  if (c > 0xFF) return std::nullopt;
  return static_cast<unsigned char>(c);
}

/// Windows-1252, and Latin-1 where a control character shows that the two were mixed.
std::optional<unsigned char> to_western(char32_t c) {
  const auto byte = to_windows_1252(c);
  return byte ? byte : to_latin_1(c);
}

bool is_ascii(std::u32string_view text) {
  return std::all_of(text.begin(), text.end(), [](char32_t c) { return c < 0x80; });
}

/// What follows letters in honest text: a closing quote, a dash, an ellipsis, a sign of registration.
bool may_follow_a_letter(char32_t c) {
  constexpr std::u32string_view marks = U"\u00A0\u2026\u2013\u2014\u2018\u2019\u201C\u201D\u00BB\u203A\u00AE\u2122";
  return marks.find(c) != std::u32string_view::npos;
}

/// Latin capitals that begin the UTF-8 of Western letters and signs, and hardly any word with such a mark behind.
bool is_usual_lead(char32_t c) { return c == 0xC2 || c == 0xC3 || c == 0xCE || c == 0xD0; }

/// Whether characters that could be one character's UTF-8 are hardly anything else.
bool is_telling(std::u32string_view sequence) {
  if (is_usual_lead(sequence.front())) return true;
  return !std::all_of(sequence.begin() + 1, sequence.end(), may_follow_a_letter);
}

std::optional<std::string> bytes_of(std::u32string_view text, const ToByte& to_byte) {
  std::string bytes;
  for (const char32_t c : text) {
    const auto byte = to_byte(c);
    if (!byte) return std::nullopt;
    bytes.push_back(static_cast<char>(*byte));
  }
  return bytes;
}

/// "Ã " was "Ã" and a no-break space, the second half of an "à", which some program took for a space: of a word by
/// itself, the space after it went as well.
std::string with_lost_spaces(std::string_view bytes) {
  std::string out;
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    out.push_back(bytes[at]);
    const bool lead = bytes[at] == '\xC3' || bytes[at] == '\xC2';
    if (!lead || at + 1 == bytes.size() || bytes[at + 1] != ' ') continue;
    ++at;
    out.push_back('\xA0');
    if (bytes[at - 1] == '\xC3' && at + 1 < bytes.size() && bytes[at + 1] != ' ') out.push_back(' ');
  }
  return out;
}

/// The line as it was before it was read by `to_byte`'s encoding, if all of it was, with at least `least` telling
/// sequences in it.
std::optional<std::u32string> whole_line(std::u32string_view line, const ToByte& to_byte, int least) {
  const auto bytes = bytes_of(line, to_byte);
  if (!bytes) return std::nullopt;
  int telling = 0;
  for (std::size_t at = 0; at < bytes->size();) {
    const DecodedCharacter decoded = decode_character(*bytes, at);
    const bool lost_space =
        !decoded.valid && (line[at] == 0xC3 || line[at] == 0xC2) && at + 1 < line.size() && line[at + 1] == ' ';
    if (!decoded.valid && !lost_space) return std::nullopt;
    if (decoded.bytes > 1 && is_telling(line.substr(at, decoded.bytes))) ++telling;
    // With a space lost, a lower-case letter before it tells as much.
    if (lost_space && (at == 0 || (line[at - 1] >= 'a' && line[at - 1] <= 'z') || line[at - 1] == ' ')) ++telling;
    at += decoded.bytes;
  }
  if (telling < least) return std::nullopt;
  return decode_utf8(with_lost_spaces(*bytes));
}

/// Telling sequences replaced one by one, for lines that hold other characters, too.
std::u32string piece_by_piece(std::u32string_view line) {
  std::u32string out;
  for (std::size_t at = 0; at < line.size();) {
    std::size_t taken = 1;
    char32_t character = line[at];
    for (std::size_t length = 2; length <= 4 && at + length <= line.size() && line[at] >= 0xC2; ++length) {
      const auto bytes = bytes_of(line.substr(at, length), to_western);
      if (!bytes) break;
      const DecodedCharacter decoded = decode_character(*bytes, 0);
      if (!decoded.valid || decoded.bytes != length || !is_telling(line.substr(at, length))) continue;
      taken = length;
      character = decoded.character;
    }
    out += character;
    at += taken;
  }
  return out;
}

std::u32string repaired_once(std::u32string_view line) {
  // Russian words in which every second letter is a capital R or S are rare, but not unheard of.
  constexpr int telling_western = 1, telling_russian = 3;
  if (auto whole = whole_line(line, to_latin_1, telling_western)) return *whole;
  if (auto whole = whole_line(line, to_western, telling_western)) return *whole;
  if (auto whole = whole_line(line, to_windows_1251, telling_russian)) return *whole;
  return piece_by_piece(line);
}

}  // namespace

std::u32string repair_mojibake(std::u32string_view line) {
  constexpr int most_readings = 8;
  std::u32string text(line);
  for (int i = 0; i < most_readings && !is_ascii(text); ++i) {
    std::u32string repaired = repaired_once(text);
    if (repaired == text) break;
    text = std::move(repaired);
  }
  for (char32_t& c : text)
    if (c >= 0x80 && c < 0xA0) c = from_windows_1252(c);
  return text;
}

}  // namespace uwv::model
