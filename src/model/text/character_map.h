// SPDX-License-Identifier: Apache-2.0
// The normalisation a tokenizer was trained with: short strings and what they are replaced by, kept as SentencePiece
// stores them ("precompiled charsmap"): u32 length of the trie in bytes, a double-array trie of u32 units, and the
// replacements as strings that end in a zero byte. The trie's values are offsets of replacements.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace uwv::model {

class CharacterMap {
 public:
  /// Replaces nothing.
  CharacterMap() = default;
  /// `bytes` as above, empty for a map that replaces nothing. Throws Error(file_damaged) beginning with `where` when
  /// the lengths lie; a trie that leads outside itself afterwards is read as having no such entry.
  CharacterMap(std::string_view bytes, const std::string& where);

  /// Normalises valid UTF-8 as transformers' fast tokenizers do: each grapheme cluster shorter than 6 bytes that
  /// begins with an entry is replaced as a whole by what that (shortest) entry maps to, of all others each character
  /// for itself. SentencePiece's own rule, the longest entry at each place, differs in rare clusters.
  std::string normalise(std::string_view text) const;

 private:
  /// The replacement of the shortest entry that `text` begins with.
  std::optional<std::string_view> replacement(std::string_view text) const;

  std::vector<std::uint32_t> units_;
  std::string replacements_;
};

}  // namespace uwv::model
