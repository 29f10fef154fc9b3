// SPDX-License-Identifier: Apache-2.0
#include "model/text/tokenizer.h"

#include <algorithm>

#include "model/text/utf8.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

constexpr std::string_view word_mark = "\xE2\x96\x81";  // U+2581

}  // namespace

std::size_t Tokens::length() const { return static_cast<std::size_t>(std::count(mask.begin(), mask.end(), 1)); }

Tokenizer Tokenizer::open(const std::string& folder) { return Tokenizer(read_tokenizer(folder)); }

Tokenizer::Tokenizer(TokenizerParts parts) : parts_(std::move(parts)) {
  std::stable_sort(parts_.added.begin(), parts_.added.end(),
                   [](const AddedToken& a, const AddedToken& b) { return a.text.size() > b.text.size(); });
  ids_ = static_cast<std::int64_t>(parts_.model.size());
  for (const AddedToken& token : parts_.added) {
    ids_ = std::max(ids_, token.id + 1);
    if (added_beginnings_.find(token.text[0]) == std::string::npos) added_beginnings_ += token.text[0];
  }
}

const AddedToken* Tokenizer::added_at(std::string_view text) const {
  for (const AddedToken& token : parts_.added)
    if (text.starts_with(token.text)) return &token;
  return nullptr;
}

std::vector<std::int64_t> Tokenizer::encode(std::string_view text) const {
  if (text.size() > max_text_bytes)
    fail(ErrorCode::value_invalid,
         "the prompt has {} bytes; at most {} are read, and of those the encoder takes in the "
         "first few hundred words",
         text.size(), max_text_bytes);
  const std::string valid = valid_utf8(text);
  std::string_view rest = valid;
  std::vector<std::int64_t> ids;
  for (std::size_t at = 0; (at = rest.find_first_of(added_beginnings_, at)) != std::string_view::npos;) {
    const AddedToken* token = added_at(rest.substr(at));
    if (token == nullptr) {
      ++at;
      continue;
    }
    append_plain(rest.substr(0, at), ids);
    ids.push_back(token->id);
    rest.remove_prefix(at + token->text.size());
    at = 0;
  }
  append_plain(rest, ids);
  ids.push_back(parts_.end);
  return ids;
}

Tokens Tokenizer::encode(std::string_view text, std::size_t max_length) const {
  require(max_length > 0, "a prompt cannot be cut to {} tokens; at least 1 is wanted", max_length);
  Tokens tokens{encode(text), {}};
  if (tokens.ids.size() > max_length) {
    tokens.ids.resize(max_length);
    tokens.ids.back() = parts_.end;
  }
  tokens.mask.assign(tokens.ids.size(), 1);
  tokens.ids.resize(max_length, parts_.padding);
  tokens.mask.resize(max_length, 0);
  return tokens;
}

void Tokenizer::append_plain(std::string_view text, std::vector<std::int64_t>& ids) const {
  const std::string normal = parts_.character_map.normalise(text);
  std::size_t word = 0;
  for (std::size_t at = 0; at < normal.size();) {
    const DecodedCharacter decoded = decode_character(normal, at);
    if (is_white_space(decoded.character)) {
      append_word(std::string_view(normal).substr(word, at - word), ids);
      word = at + decoded.bytes;
    }
    at += decoded.bytes;
  }
  append_word(std::string_view(normal).substr(word), ids);
}

void Tokenizer::append_word(std::string_view word, std::vector<std::int64_t>& ids) const {
  if (word.empty()) return;
  // A mark written in the text begins a word too.
  std::string marked = word.starts_with(word_mark) ? std::string() : std::string(word_mark);
  marked += word;
  for (std::size_t begin = 0; begin < marked.size();) {
    const std::size_t end = std::min(marked.find(word_mark, begin + word_mark.size()), marked.size());
    parts_.model.encode(std::string_view(marked).substr(begin, end - begin), ids);
    begin = end;
  }
}

}  // namespace uwv::model
