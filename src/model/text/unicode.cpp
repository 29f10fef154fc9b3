// SPDX-License-Identifier: Apache-2.0
#include "model/text/unicode.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <map>
#include <utility>

#include "model/text/utf8.h"

namespace uwv::model {
namespace {

struct CharacterRange {
  char32_t first, last;
};
struct CombiningClass {
  char32_t first, last;
  std::uint8_t order;
};
struct Decomposition {
  char32_t character, first, second;  // second 0: the character is another name of `first`
  bool composes;                      // false: Unicode excludes it from composition
};
struct PlainForm {
  char32_t character;
  const char* text;
};

#include "model/text/unicode_tables.inc"

// Hangul syllables are computed: leading consonant, vowel, and optional trailing consonant.
constexpr char32_t syllable_base = 0xAC00, leading_base = 0x1100, vowel_base = 0x1161, trailing_base = 0x11A7;
constexpr char32_t leadings = 19, vowels = 21, trailings = 28;
constexpr char32_t syllables = leadings * vowels * trailings;

/// The range of a sorted table that holds `c`, or null.
template <class Range, std::size_t n>
const Range* range_of(const Range (&table)[n], char32_t c) {
  const auto* found =
      std::upper_bound(std::begin(table), std::end(table), c, [](char32_t x, const Range& r) { return x < r.first; });
  if (found == std::begin(table) || c > std::prev(found)->last) return nullptr;
  return std::prev(found);
}

int combining_class(char32_t c) {
  const auto* range = range_of(combining_classes, c);
  return range == nullptr ? 0 : range->order;
}

void append_decomposed(std::u32string& out, char32_t c) {
  if (c >= syllable_base && c < syllable_base + syllables) {
    const char32_t i = c - syllable_base;
    out += leading_base + i / (vowels * trailings);
    out += vowel_base + i % (vowels * trailings) / trailings;
    if (i % trailings != 0) out += trailing_base + i % trailings;
    return;
  }
  const auto* found = std::lower_bound(std::begin(decompositions), std::end(decompositions), c,
                                       [](const Decomposition& d, char32_t x) { return d.character < x; });
  if (found == std::end(decompositions) || found->character != c) {
    out += c;
    return;
  }
  append_decomposed(out, found->first);
  if (found->second != 0) append_decomposed(out, found->second);
}

/// What two characters compose to, 0 for nothing.
char32_t composed(char32_t first, char32_t second) {
  static const auto pairs = [] {
    std::map<std::pair<char32_t, char32_t>, char32_t> map;
    for (const Decomposition& d : decompositions)
      if (d.composes && d.second != 0) map.emplace(std::pair(d.first, d.second), d.character);
    return map;
  }();
  if (first >= leading_base && first < leading_base + leadings && second >= vowel_base && second < vowel_base + vowels)
    return syllable_base + ((first - leading_base) * vowels + (second - vowel_base)) * trailings;
  if (first >= syllable_base && first < syllable_base + syllables && (first - syllable_base) % trailings == 0 &&
      second > trailing_base && second < trailing_base + trailings)
    return first + (second - trailing_base);
  const auto found = pairs.find({first, second});
  return found == pairs.end() ? 0 : found->second;
}

/// Sorts each run of marks by class; marks of one class keep their order.
void order_marks(std::u32string& text) {
  for (auto at = text.begin(); at != text.end();) {
    if (combining_class(*at) == 0) {
      ++at;
      continue;
    }
    const auto end = std::find_if(at, text.end(), [](char32_t c) { return combining_class(c) == 0; });
    std::stable_sort(at, end, [](char32_t a, char32_t b) { return combining_class(a) < combining_class(b); });
    at = end;
  }
}

}  // namespace

bool is_control(char32_t c) { return c < 0x20 || (c >= 0x7F && c < 0xA0) || c == 0x2028 || c == 0x2029; }
bool continues_cluster(char32_t c) { return range_of(cluster_marks, c) != nullptr; }

std::u32string_view plain_form(char32_t c) {
  static const auto forms = [] {
    std::map<char32_t, std::u32string> map;
    for (const PlainForm& form : plain_forms) map.emplace(form.character, decode_utf8(form.text));
    return map;
  }();
  const auto found = forms.find(c);
  return found == forms.end() ? std::u32string_view() : std::u32string_view(found->second);
}

std::u32string nfc(std::u32string_view text) {
  std::u32string parts;
  parts.reserve(text.size());
  for (const char32_t c : text) append_decomposed(parts, c);
  order_marks(parts);

  std::u32string out;
  std::size_t starter = std::u32string::npos;  // where the last character of class 0 is in `out`
  for (const char32_t c : parts) {
    const int order = combining_class(c);
    // A mark joins its starter unless another of the same or higher class, or a starter, stands between.
    const bool adjacent = starter != std::u32string::npos && starter + 1 == out.size();
    if (starter != std::u32string::npos && (adjacent || combining_class(out.back()) < order)) {
      if (const char32_t whole = composed(out[starter], c); whole != 0) {
        out[starter] = whole;
        continue;
      }
    }
    if (order == 0) starter = out.size();
    out += c;
  }
  return out;
}

}  // namespace uwv::model
