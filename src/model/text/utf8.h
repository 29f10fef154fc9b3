// SPDX-License-Identifier: Apache-2.0
// UTF-8 in and out. What is not UTF-8 becomes U+FFFD, one for each longest broken piece, as the Unicode standard
// advises.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace uwv::model {

constexpr char32_t replacement_character = 0xFFFD;

/// The character at byte `at` of `text`, and how many bytes it takes (at least 1). `at` is inside the text.
struct DecodedCharacter {
  char32_t character = 0;
  std::size_t bytes = 1;
  bool valid = true;  ///< False: `character` is U+FFFD put in place of broken bytes.
};
DecodedCharacter decode_character(std::string_view text, std::size_t at);

std::u32string decode_utf8(std::string_view text);
/// Surrogates and numbers past U+10FFFF are written as U+FFFD.
std::string encode_utf8(std::u32string_view characters);
void append_utf8(std::string& text, char32_t character);

/// The text with its broken bytes replaced.
std::string valid_utf8(std::string_view text);

/// Unicode's White_Space.
bool is_white_space(char32_t c);

}  // namespace uwv::model
