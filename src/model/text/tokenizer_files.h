// SPDX-License-Identifier: Apache-2.0
// Reads a Hugging Face tokenizer/ folder of a T5-like model: tokenizer.json, or, without one, spiece.model (a
// SentencePiece unigram model) with tokenizer_config.json for the tokens added to it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "model/text/character_map.h"
#include "model/text/unigram_model.h"

namespace uwv::model {

/// A token that is read as one wherever it is written in the text, e.g. "</s>".
struct AddedToken {
  std::string text;
  std::int64_t id = 0;
};

struct TokenizerParts {
  CharacterMap character_map;
  UnigramModel model;
  std::vector<AddedToken> added;
  std::int64_t padding = 0, end = 1;  ///< Ids of <pad> and </s>.
};

/// Throws Error: file_not_found when the folder has neither file; file_damaged when one breaks its format;
/// value_invalid when it describes another kind of tokenizer (naming what is wanted).
TokenizerParts read_tokenizer(const std::string& folder);

/// The two formats by themselves. `path` is for error sentences.
TokenizerParts parse_tokenizer_json(std::string_view text, const std::string& path);
/// `config` is the text of tokenizer_config.json, empty for none: 100 tokens "<extra_id_n>" are added then.
TokenizerParts parse_spiece_model(std::string_view bytes, const std::string& path, std::string_view config,
                                  const std::string& config_path);

}  // namespace uwv::model
