// SPDX-License-Identifier: Apache-2.0
// A unigram language model of word pieces: cuts a word into the known pieces whose scores sum to most. Sheet
// model.md, 6.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace uwv::model {

struct Piece {
  std::string text;  ///< UTF-8; U+2581 stands for the space before a word.
  double score = 0;  ///< Logarithm of its probability.
};

class UnigramModel {
 public:
  UnigramModel() = default;
  /// The id of a piece is its place. What no piece covers becomes `unknown_id`, neighbours of one kind one id; with
  /// `byte_fallback`, it becomes the pieces "<0x00>".."<0xFF>" of its bytes where the model has them all. Throws
  /// Error(file_damaged) beginning with `where` for no pieces, empty ones, scores that are no numbers, and an id out of
  /// range.
  UnigramModel(std::vector<Piece> pieces, std::int64_t unknown_id, bool byte_fallback, const std::string& where);

  std::size_t size() const { return pieces_.size(); }
  /// The id of a piece; of twins the last.
  std::optional<std::int64_t> id(std::string_view piece) const;
  /// Appends the ids of `word`, valid UTF-8.
  void encode(std::string_view word, std::vector<std::int64_t>& ids) const;

 private:
  /// Ways to end a piece at some byte of the word: the best of them.
  struct Step {
    double score = 0;
    std::size_t begin = 0;
    std::int64_t id = 0;
    bool reached = false;
  };
  /// The pieces that `text` begins with, shortest first: calls found(bytes, id).
  template <class Found>
  void each_prefix(std::string_view text, Found found) const;
  void append_unknown(std::string_view text, std::vector<std::int64_t>& ids) const;

  std::vector<Piece> pieces_;
  std::vector<std::int64_t> by_text_;  ///< Ids, sorted by text, one of each text.
  std::int64_t unknown_id_ = 0;
  double unknown_score_ = 0;
  bool byte_fallback_ = false;
};

}  // namespace uwv::model
