// SPDX-License-Identifier: Apache-2.0
#include "model/text/utf8.h"

namespace uwv::model {
namespace {

/// What the first byte of a sequence says: its length, and the range of the second byte, which is narrower than that of
/// the others where it must rule out overlong forms, surrogates and numbers past U+10FFFF.
struct Lead {
  std::size_t bytes = 0;
  unsigned char second_min = 0x80, second_max = 0xBF;
};

Lead lead_of(unsigned char first) {
  if (first < 0x80) return {1};
  if (first < 0xC2) return {0};
  if (first < 0xE0) return {2};
  if (first == 0xE0) return {3, 0xA0, 0xBF};
  if (first == 0xED) return {3, 0x80, 0x9F};
  if (first < 0xF0) return {3};
  if (first == 0xF0) return {4, 0x90, 0xBF};
  if (first < 0xF4) return {4};
  if (first == 0xF4) return {4, 0x80, 0x8F};
  return {0};
}

}  // namespace

DecodedCharacter decode_character(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const Lead lead = lead_of(byte(at));
  if (lead.bytes == 1) return {byte(at), 1, true};
  char32_t value = lead.bytes == 0 ? 0 : byte(at) & (0xFFU >> (lead.bytes + 1));
  std::size_t read = 1;
  while (read < lead.bytes && at + read < text.size()) {
    const unsigned char next = byte(at + read);
    const unsigned char min = read == 1 ? lead.second_min : 0x80;
    const unsigned char max = read == 1 ? lead.second_max : 0xBF;
    if (next < min || next > max) break;
    value = value << 6 | (next & 0x3FU);
    ++read;
  }
  if (lead.bytes == 0 || read < lead.bytes) return {replacement_character, read, false};
  return {value, read, true};
}

std::u32string decode_utf8(std::string_view text) {
  std::u32string characters;
  characters.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const DecodedCharacter decoded = decode_character(text, at);
    characters.push_back(decoded.character);
    at += decoded.bytes;
  }
  return characters;
}

void append_utf8(std::string& text, char32_t c) {
  if (c > 0x10FFFF || (c >= 0xD800 && c <= 0xDFFF)) c = replacement_character;
  const auto put = [&](char32_t byte) { text.push_back(static_cast<char>(byte)); };
  const auto tail = [&](int shift) { put(0x80 | ((c >> shift) & 0x3F)); };
  if (c < 0x80) {
    put(c);
  } else if (c < 0x800) {
    put(0xC0 | c >> 6);
    tail(0);
  } else if (c < 0x10000) {
    put(0xE0 | c >> 12);
    tail(6);
    tail(0);
  } else {
    put(0xF0 | c >> 18);
    tail(12);
    tail(6);
    tail(0);
  }
}

std::string encode_utf8(std::u32string_view characters) {
  std::string text;
  text.reserve(characters.size());
  for (const char32_t c : characters) append_utf8(text, c);
  return text;
}

std::string valid_utf8(std::string_view text) { return encode_utf8(decode_utf8(text)); }

bool is_white_space(char32_t c) {
  return (c >= 9 && c <= 13) || c == 0x20 || c == 0x85 || c == 0xA0 || c == 0x1680 || (c >= 0x2000 && c <= 0x200A) ||
         c == 0x2028 || c == 0x2029 || c == 0x202F || c == 0x205F || c == 0x3000;
}

}  // namespace uwv::model
