// SPDX-License-Identifier: Apache-2.0
// SentencePiece's model file: the message ModelProto { pieces = 1, trainer_spec = 2, normalizer_spec = 3 }.
#include <set>

#include "io/json_text.h"
#include "io/printable.h"
#include "model/text/protobuf_reader.h"
#include "model/text/tokenizer_files.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

constexpr std::uint64_t unigram = 1;       // TrainerSpec.model_type
constexpr std::uint64_t unknown_kind = 2;  // SentencePiece.type
constexpr std::uint64_t max_pieces = 10'000'000;

struct SpieceContents {
  std::vector<Piece> pieces;
  std::int64_t unknown = -1;
  std::uint64_t model_type = unigram;
  std::string_view character_map;
};

void read_piece(std::string_view message, const std::string& where, SpieceContents& contents) {
  Piece piece;
  std::uint64_t kind = 1;
  ProtobufReader reader(message, where);
  for (ProtobufField field; reader.next(field);) {
    if (field.number == 1) piece.text = field.bytes;
    if (field.number == 2 && field.kind == ProtobufField::Kind::fixed32) piece.score = double{field.as_float()};
    if (field.number == 3) kind = field.whole;
  }
  if (kind == unknown_kind) contents.unknown = static_cast<std::int64_t>(contents.pieces.size());
  if (contents.pieces.size() >= max_pieces)
    fail(ErrorCode::file_damaged, "{}: has more than {} pieces", where, max_pieces);
  contents.pieces.push_back(std::move(piece));
}

SpieceContents read_contents(std::string_view bytes, const std::string& path) {
  SpieceContents contents;
  ProtobufReader reader(bytes, path);
  for (ProtobufField field; reader.next(field);) {
    if (field.number == 1) read_piece(field.bytes, path, contents);
    if (field.number != 2 && field.number != 3) continue;
    ProtobufReader inner(field.bytes, path);
    for (ProtobufField part; inner.next(part);) {
      if (field.number == 2 && part.number == 3) contents.model_type = part.whole;
      if (field.number == 3 && part.number == 2) contents.character_map = part.bytes;
    }
  }
  return contents;
}

/// Tokens "<extra_id_0>" to "<extra_id_{count-1}>" follow the pieces, the last of them first.
void add_sentinels(std::int64_t count, std::int64_t first_id, std::vector<AddedToken>& added) {
  for (std::int64_t n = 0; n < count; ++n)
    added.push_back({"<extra_id_" + std::to_string(n) + ">", first_id + count - 1 - n});
}

/// What tokenizer_config.json adds: a table by id, or a number of sentinels.
void read_added(std::string_view config, const std::string& path, std::int64_t first_id,
                std::vector<AddedToken>& added) {
  constexpr std::int64_t usual_sentinels = 100, most_sentinels = 100'000;
  const nlohmann::json json = config.empty() ? nlohmann::json::object() : io::parse_json(config, path);
  if (!json.is_object()) fail(ErrorCode::file_damaged, "{}: is no JSON object", path);
  const auto table = json.find("added_tokens_decoder");
  if (table == json.end()) {
    const auto count = json.find("extra_ids");
    if (count != json.end() && !(count->is_number_unsigned() && count->get<std::uint64_t>() <= most_sentinels))
      fail(ErrorCode::file_damaged, "{}: 'extra_ids' is no whole number from 0 to {}", path, most_sentinels);
    return add_sentinels(count == json.end() ? usual_sentinels : count->get<std::int64_t>(), first_id, added);
  }
  if (!table->is_object()) fail(ErrorCode::file_damaged, "{}: 'added_tokens_decoder' is no object", path);
  for (const auto& [key, token] : table->items()) {
    const bool number = !key.empty() && key.size() < 10 && key.find_first_not_of("0123456789") == std::string::npos;
    const auto content = token.is_object() ? token.find("content") : token.end();
    if (!number || !token.is_object() || content == token.end() || !content->is_string() ||
        content->get_ref<const std::string&>().empty())
      fail(ErrorCode::file_damaged, "{}: 'added_tokens_decoder' has an entry '{}' that is no id with 'content'", path,
           io::printable(key));
    added.push_back({content->get<std::string>(), std::stol(key)});
  }
}

}  // namespace

TokenizerParts parse_spiece_model(std::string_view bytes, const std::string& path, std::string_view config,
                                  const std::string& config_path) {
  SpieceContents contents = read_contents(bytes, path);
  if (contents.model_type != unigram)
    fail(ErrorCode::value_invalid, "{}: is a SentencePiece model of type {}; a unigram model (1) is wanted", path,
         contents.model_type);
  if (contents.unknown < 0) fail(ErrorCode::file_damaged, "{}: has no piece for the unknown", path);
  TokenizerParts parts;
  parts.character_map = CharacterMap(contents.character_map, path);
  const auto count = static_cast<std::int64_t>(contents.pieces.size());
  parts.added.push_back({contents.pieces[static_cast<std::size_t>(contents.unknown)].text, contents.unknown});
  // transformers does not fall back to bytes for T5's tokenizers, whatever the file says.
  parts.model = UnigramModel(std::move(contents.pieces), contents.unknown, /*byte_fallback=*/false, path);
  for (const auto& [text, id] : {std::pair("<pad>", &parts.padding), std::pair("</s>", &parts.end)}) {
    const auto found = parts.model.id(text);
    if (!found) fail(ErrorCode::value_invalid, "{}: has no piece '{}'; is it the model of a T5 tokenizer?", path, text);
    *id = *found;
    parts.added.push_back({text, *found});
  }
  read_added(config, config_path, count, parts.added);
  return parts;
}

}  // namespace uwv::model
