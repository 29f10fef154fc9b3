// SPDX-License-Identifier: Apache-2.0
#include "model/text/character_map.h"

#include <cstring>

#include "model/text/unicode.h"
#include "model/text/utf8.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

/// Longer clusters are not looked up as a whole.
constexpr std::size_t max_cluster_bytes = 5;

// A unit of the double array: bits 0-7 and 31 the label by which it is reached, 8 whether it has a value, 10-30 the
// distance to its children, which bit 9 makes 256 times as large. A unit that holds a value has bit 31 set.
bool has_value(std::uint32_t unit) { return (unit >> 8 & 1U) != 0; }
std::uint32_t label(std::uint32_t unit) { return unit & 0x800000FFU; }
std::uint32_t value(std::uint32_t unit) { return unit & 0x7FFFFFFFU; }
std::uint32_t distance(std::uint32_t unit) { return (unit >> 10) << ((unit & 1U << 9) >> 6); }

/// Bytes of the cluster that begins `text`: a character with the marks that follow it, or a line's end.
std::size_t cluster_bytes(std::string_view text) {
  if (text.starts_with("\r\n")) return 2;
  const DecodedCharacter base = decode_character(text, 0);
  std::size_t bytes = base.bytes;
  if (is_control(base.character)) return bytes;
  while (bytes < text.size()) {
    const DecodedCharacter next = decode_character(text, bytes);
    if (!continues_cluster(next.character)) break;
    bytes += next.bytes;
  }
  return bytes;
}

}  // namespace

CharacterMap::CharacterMap(std::string_view bytes, const std::string& where) {
  if (bytes.empty()) return;
  std::uint32_t trie_bytes = 0;
  if (bytes.size() < sizeof trie_bytes)
    fail(ErrorCode::file_damaged, "{}: its character map has {} bytes; at least 4 are wanted", where, bytes.size());
  std::memcpy(&trie_bytes, bytes.data(), sizeof trie_bytes);
  bytes.remove_prefix(sizeof trie_bytes);
  if (trie_bytes > bytes.size() || trie_bytes % sizeof(std::uint32_t) != 0)
    fail(ErrorCode::file_damaged, "{}: its character map claims a trie of {} bytes and has {}", where, trie_bytes,
         bytes.size());
  units_.resize(trie_bytes / sizeof(std::uint32_t));
  if (trie_bytes > 0) std::memcpy(units_.data(), bytes.data(), trie_bytes);
  replacements_ = bytes.substr(trie_bytes);
}

std::optional<std::string_view> CharacterMap::replacement(std::string_view text) const {
  if (units_.empty()) return std::nullopt;
  std::size_t at = distance(units_[0]);
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte == 0) break;
    at ^= byte;
    if (at >= units_.size() || label(units_[at]) != byte) break;
    const std::uint32_t unit = units_[at];
    at ^= distance(unit);
    if (!has_value(unit)) continue;
    if (at >= units_.size() || value(units_[at]) >= replacements_.size()) break;
    const std::string_view rest = std::string_view(replacements_).substr(value(units_[at]));
    return rest.substr(0, rest.find('\0'));
  }
  return std::nullopt;
}

std::string CharacterMap::normalise(std::string_view text) const {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const std::size_t bytes = cluster_bytes(text);
    std::string_view cluster = text.substr(0, bytes);
    text.remove_prefix(bytes);
    if (bytes <= max_cluster_bytes)
      if (const auto whole = replacement(cluster)) {
        out += *whole;
        continue;
      }
    while (!cluster.empty()) {
      const std::string_view character = cluster.substr(0, decode_character(cluster, 0).bytes);
      cluster.remove_prefix(character.size());
      out += replacement(character).value_or(character);
    }
  }
  return out;
}

}  // namespace uwv::model
