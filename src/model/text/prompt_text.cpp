// SPDX-License-Identifier: Apache-2.0
#include "model/text/prompt_text.h"

#include <algorithm>

#include "model/text/html_text.h"
#include "model/text/mojibake.h"
#include "model/text/unicode.h"
#include "model/text/utf8.h"

namespace uwv::model {
namespace {

constexpr char32_t escape = 0x1B;

bool is_single_quote(char32_t c) { return c == 0x2BC || (c >= 0x2018 && c <= 0x201B); }
bool is_double_quote(char32_t c) { return c >= 0x201C && c <= 0x201F; }

/// Characters that say how text is to be shown, or nothing.
bool is_unseen(char32_t c) {
  return c < 9 || c == 0xB || (c >= 0xE && c < 0x20) || c == 0x7F || (c >= 0x206A && c <= 0x206F) || c == 0xFEFF ||
         (c >= 0xFFF9 && c <= 0xFFFC);
}

/// Bytes of a terminal's colour code at `at`: escape, "[", numbers and semicolons, a letter; 0 for none.
std::size_t terminal_code(std::u32string_view text, std::size_t at) {
  if (text[at] != escape || at + 1 >= text.size() || text[at + 1] != '[') return 0;
  std::size_t end = at + 2;
  while (end < text.size() && ((text[end] >= '0' && text[end] <= '9') || text[end] == ';')) ++end;
  const bool letter =
      end < text.size() && ((text[end] >= 'a' && text[end] <= 'z') || (text[end] >= 'A' && text[end] <= 'Z'));
  return letter ? end + 1 - at : 0;
}

std::u32string plain_characters(std::u32string_view text) {
  std::u32string out;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char32_t c = text[at];
    if (const std::size_t code = terminal_code(text, at); code > 0) {
      at += code - 1;
    } else if (is_single_quote(c)) {
      out += U'\'';
    } else if (is_double_quote(c)) {
      out += U'"';
    } else if (const auto plain = plain_form(c); !plain.empty()) {
      out += plain;
    } else if (c == '\r' || c == 0x2028 || c == 0x2029 || c == 0x85) {
      if (c != '\r' || at + 1 == text.size() || text[at + 1] != '\n') out += U'\n';
    } else if (!is_unseen(c)) {
      out += c;
    }
  }
  return out;
}

/// One line, repaired until nothing changes any more.
std::string repaired_line(std::string line, bool may_be_html) {
  constexpr int most_rounds = 16;
  for (int i = 0; i < most_rounds; ++i) {
    const std::string unescaped = may_be_html ? unescape_html(line, HtmlReferences::closed) : line;
    std::string repaired = encode_utf8(nfc(plain_characters(repair_mojibake(decode_utf8(unescaped)))));
    if (repaired == line) break;
    line = std::move(repaired);
  }
  return line;
}

std::string repaired_text(const std::string& text) {
  std::string out;
  bool may_be_html = true;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t newline = text.find('\n', begin);
    const std::size_t end = newline == std::string::npos ? text.size() : newline + 1;
    std::string line = text.substr(begin, end - begin);
    // Markup means that references are part of it.
    may_be_html = may_be_html && line.find('<') == std::string::npos;
    out += repaired_line(std::move(line), may_be_html);
    begin = end;
  }
  return out;
}

/// White space as Python's regular expressions see it.
bool separates(char32_t c) { return is_white_space(c) || (c >= 0x1C && c <= 0x1F); }

std::string with_single_spaces(std::string_view text) {
  std::u32string out;
  for (const char32_t c : decode_utf8(text)) {
    if (!separates(c))
      out += c;
    else if (!out.empty() && out.back() != U' ')
      out += U' ';
  }
  if (!out.empty() && out.back() == U' ') out.pop_back();
  return encode_utf8(out);
}

}  // namespace

std::string clean_prompt(std::string_view prompt) {
  const std::string repaired = repaired_text(valid_utf8(prompt));
  return with_single_spaces(unescape_html(unescape_html(repaired, HtmlReferences::all), HtmlReferences::all));
}

}  // namespace uwv::model
