// SPDX-License-Identifier: Apache-2.0
// What text cleaning and tokenizing need to know of Unicode.
#pragma once

#include <string>
#include <string_view>

namespace uwv::model {

/// Line ends and the control characters of ASCII and Latin-1: they stand for themselves.
bool is_control(char32_t c);
/// A mark that belongs to the character before it: what extends a grapheme cluster.
bool continues_cluster(char32_t c);

/// The plain text of a full-width or half-width form or a Latin ligature; empty for every other character.
std::u32string_view plain_form(char32_t c);

/// Normalization form C: decomposed, marks ordered, composed again.
std::u32string nfc(std::u32string_view text);

}  // namespace uwv::model
