// SPDX-License-Identifier: Apache-2.0
// Turns a prompt into the token ids that the text encoder was trained on: those of transformers' fast T5 tokenizer.
// Sheet model.md, 4 and 6.
//
// Tokens written out in the text ("</s>", "<extra_id_3>") are taken first; what lies between is normalised, split at
// white space, and each word, led by U+2581, cut into pieces. Nothing of a character outside the vocabulary is kept:
// it becomes the unknown token.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "model/text/tokenizer_files.h"

namespace uwv::model {

/// Ids and which of them are text (1) or padding (0); both of the length asked for.
struct Tokens {
  std::vector<std::int64_t> ids, mask;
  std::size_t length() const;  ///< How many are text, the end token among them.
};

class Tokenizer {
 public:
  /// The longest prompt, in bytes, that is read; far more than the encoder can take in.
  static constexpr std::size_t max_text_bytes = 1'000'000;

  /// Reads a folder tokenizer/; throws as read_tokenizer does.
  static Tokenizer open(const std::string& folder);
  explicit Tokenizer(TokenizerParts parts);

  /// All ids of the text and the end token. Broken UTF-8 is read as U+FFFD. Throws Error(value_invalid) for a text
  /// longer than max_text_bytes.
  std::vector<std::int64_t> encode(std::string_view text) const;
  /// The same cut to max_length, the end token kept as the last, or padded to it. max_length is 1 or more.
  Tokens encode(std::string_view text, std::size_t max_length) const;

  /// One more than the largest id it gives; the encoder's table of embeddings has at least as many rows.
  std::int64_t ids() const { return ids_; }

 private:
  void append_plain(std::string_view text, std::vector<std::int64_t>& ids) const;
  void append_word(std::string_view word, std::vector<std::int64_t>& ids) const;
  /// The longest added token that `text` begins with, or null.
  const AddedToken* added_at(std::string_view text) const;

  TokenizerParts parts_;  // added tokens by falling length
  std::string added_beginnings_;
  std::int64_t ids_ = 0;
};

}  // namespace uwv::model
