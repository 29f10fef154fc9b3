// SPDX-License-Identifier: Apache-2.0
#include "model/text/unigram_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "model/text/utf8.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

/// How much less likely an unknown character is than the least likely piece; SentencePiece's and transformers' choice.
constexpr double unknown_penalty = 10;

}  // namespace

UnigramModel::UnigramModel(std::vector<Piece> pieces, std::int64_t unknown_id, bool byte_fallback,
                           const std::string& where)
    : pieces_(std::move(pieces)), unknown_id_(unknown_id), byte_fallback_(byte_fallback) {
  if (pieces_.empty()) fail(ErrorCode::file_damaged, "{}: has no word pieces", where);
  if (unknown_id < 0 || unknown_id >= static_cast<std::int64_t>(pieces_.size()))
    fail(ErrorCode::file_damaged, "{}: the piece for the unknown has id {} of {}", where, unknown_id, pieces_.size());
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    if (pieces_[i].text.empty() || !std::isfinite(pieces_[i].score))
      fail(ErrorCode::file_damaged, "{}: piece {} is empty or its score is no number", where, i);
    least = std::min(least, pieces_[i].score);
  }
  unknown_score_ = least - unknown_penalty;

  by_text_.resize(pieces_.size());
  std::iota(by_text_.begin(), by_text_.end(), 0);
  const auto text = [&](std::int64_t id) -> const std::string& { return pieces_[static_cast<std::size_t>(id)].text; };
  // Of twins, the last comes first and stays.
  std::sort(by_text_.begin(), by_text_.end(), [&](std::int64_t a, std::int64_t b) {
    const int order = text(a).compare(text(b));
    return order != 0 ? order < 0 : a > b;
  });
  by_text_.erase(
      std::unique(by_text_.begin(), by_text_.end(), [&](std::int64_t a, std::int64_t b) { return text(a) == text(b); }),
      by_text_.end());
}

std::optional<std::int64_t> UnigramModel::id(std::string_view piece) const {
  const auto found = std::lower_bound(
      by_text_.begin(), by_text_.end(), piece,
      [&](std::int64_t id, std::string_view wanted) { return pieces_[static_cast<std::size_t>(id)].text < wanted; });
  if (found == by_text_.end() || pieces_[static_cast<std::size_t>(*found)].text != piece) return std::nullopt;
  return *found;
}

template <class Found>
void UnigramModel::each_prefix(std::string_view text, Found found) const {
  // The pieces that share the first `bytes` bytes are one run of the sorted list, narrowed byte by byte.
  auto first = by_text_.begin();
  auto last = by_text_.end();
  for (std::size_t bytes = 0; bytes < text.size() && first != last; ++bytes) {
    const auto at = [&](std::int64_t id) {
      const std::string& piece = pieces_[static_cast<std::size_t>(id)].text;
      return bytes < piece.size() ? int{static_cast<unsigned char>(piece[bytes])} : -1;
    };
    const int wanted = static_cast<unsigned char>(text[bytes]);
    first = std::lower_bound(first, last, wanted, [&](std::int64_t id, int byte) { return at(id) < byte; });
    last = std::upper_bound(first, last, wanted, [&](int byte, std::int64_t id) { return byte < at(id); });
    if (first != last && pieces_[static_cast<std::size_t>(*first)].text.size() == bytes + 1) found(bytes + 1, *first);
  }
}

void UnigramModel::encode(std::string_view word, std::vector<std::int64_t>& ids) const {
  std::vector<Step> best(word.size() + 1);
  for (std::size_t begin = 0; begin < word.size();) {
    const double so_far = best[begin].score;
    const auto offer = [&](std::size_t bytes, double score, std::int64_t id) {
      Step& step = best[begin + bytes];
      if (!step.reached || so_far + score > step.score) step = {so_far + score, begin, id, true};
    };
    const std::size_t character = decode_character(word, begin).bytes;
    bool character_known = false;
    each_prefix(word.substr(begin), [&](std::size_t bytes, std::int64_t id) {
      offer(bytes, pieces_[static_cast<std::size_t>(id)].score, id);
      character_known = character_known || bytes == character;
    });
    if (!character_known) offer(character, unknown_score_, unknown_id_);
    begin += character;
  }

  std::vector<std::size_t> ends;
  for (std::size_t end = word.size(); end > 0; end = best[end].begin) ends.push_back(end);
  for (std::size_t i = ends.size(); i-- > 0;) {
    if (best[ends[i]].id != unknown_id_) {
      ids.push_back(best[ends[i]].id);
      continue;
    }
    const std::size_t begin = best[ends[i]].begin;
    while (i > 0 && best[ends[i - 1]].id == unknown_id_) --i;
    append_unknown(word.substr(begin, ends[i] - begin), ids);
  }
}

void UnigramModel::append_unknown(std::string_view text, std::vector<std::int64_t>& ids) const {
  std::vector<std::int64_t> bytes;
  for (const char c : byte_fallback_ ? text : std::string_view())
    if (const auto byte = id(fmt::format("<0x{:02X}>", static_cast<unsigned char>(c)))) bytes.push_back(*byte);
  if (byte_fallback_ && bytes.size() == text.size())
    ids.insert(ids.end(), bytes.begin(), bytes.end());
  else
    ids.push_back(unknown_id_);
}

}  // namespace uwv::model
