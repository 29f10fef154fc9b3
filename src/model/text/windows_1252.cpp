// SPDX-License-Identifier: Apache-2.0
#include "model/text/windows_1252.h"

#include <algorithm>
#include <array>

#include "model/text/utf8.h"

namespace uwv::model {
namespace {

/// Bytes 0x80 to 0x9F of Windows-1252; the others are Latin-1's.
constexpr std::array<char32_t, 0x20> upper_1252{0x20ac, 0x0081, 0x201a, 0x0192, 0x201e, 0x2026, 0x2020, 0x2021,
                                                0x02c6, 0x2030, 0x0160, 0x2039, 0x0152, 0x008d, 0x017d, 0x008f,
                                                0x0090, 0x2018, 0x2019, 0x201c, 0x201d, 0x2022, 0x2013, 0x2014,
                                                0x02dc, 0x2122, 0x0161, 0x203a, 0x0153, 0x009d, 0x017e, 0x0178};

/// Bytes 0x80 to 0xBF of Windows-1251; then the letters of Russian follow in order.
constexpr std::array<char32_t, 0x40> upper_1251{
    0x0402, 0x0403, 0x201a, 0x0453, 0x201e, 0x2026, 0x2020, 0x2021, 0x20ac, 0x2030, 0x0409, 0x2039, 0x040a,
    0x040c, 0x040b, 0x040f, 0x0452, 0x2018, 0x2019, 0x201c, 0x201d, 0x2022, 0x2013, 0x2014, 0x0098, 0x2122,
    0x0459, 0x203a, 0x045a, 0x045c, 0x045b, 0x045f, 0x00a0, 0x040e, 0x045e, 0x0408, 0x00a4, 0x0490, 0x00a6,
    0x00a7, 0x0401, 0x00a9, 0x0404, 0x00ab, 0x00ac, 0x00ad, 0x00ae, 0x0407, 0x00b0, 0x00b1, 0x0406, 0x0456,
    0x0491, 0x00b5, 0x00b6, 0x00b7, 0x0451, 0x2116, 0x0454, 0x00bb, 0x0458, 0x0405, 0x0455, 0x0457};
constexpr char32_t first_russian = 0x410, last_russian = 0x44F;

template <std::size_t n>
std::optional<unsigned char> byte_in(const std::array<char32_t, n>& table, char32_t c) {
  const auto found = std::find(table.begin(), table.end(), c);
  if (found == table.end()) return std::nullopt;
  return static_cast<unsigned char>(0x80 + (found - table.begin()));
}

}  // namespace

char32_t from_windows_1252(std::uint32_t byte) { return byte >= 0x80 && byte < 0xA0 ? upper_1252[byte - 0x80] : byte; }

std::optional<unsigned char> to_windows_1252(char32_t c) {
  if (c < 0x80 || (c >= 0xA0 && c <= 0xFF)) return static_cast<unsigned char>(c);
  return byte_in(upper_1252, c);
}

std::optional<unsigned char> to_windows_1251(char32_t c) {
  if (c < 0x80) return static_cast<unsigned char>(c);
  if (c >= first_russian && c <= last_russian) return static_cast<unsigned char>(0xC0 + (c - first_russian));
  return byte_in(upper_1251, c);
}

std::string capital_letters(std::string_view text) {
  std::u32string characters = decode_utf8(text);
  for (char32_t& c : characters)
    if ((c >= 'a' && c <= 'z') || (c >= 0xE0 && c <= 0xFE && c != 0xF7)) c -= 0x20;
  return encode_utf8(characters);
}

}  // namespace uwv::model
