// SPDX-License-Identifier: Apache-2.0
#include "model/text/tokenizer_files.h"

#include <algorithm>
#include <filesystem>

#include "io/disk_file.h"
#include "io/json_text.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/// The largest tokenizers in use have 20 MB.
constexpr std::uint64_t max_file_bytes = 200'000'000;

std::string decode_base64(const std::string& text, const std::string& where) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t bits = 0;
  int held = 0;
  for (const char c : std::string_view(text).substr(0, text.find('='))) {
    const auto digit = digits.find(c);
    if (digit == std::string_view::npos) fail(ErrorCode::file_damaged, "{}: its character map is not base64", where);
    bits = (bits << 6 | static_cast<std::uint32_t>(digit)) & 0xFFFFFU;
    held += 6;
    if (held < 8) continue;
    held -= 8;
    bytes.push_back(static_cast<char>(bits >> held & 0xFFU));
  }
  return bytes;
}

/// A member of an object, or null.
const json* find(const json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

std::string type_of(const json& object) {
  const json* type = find(object, "type");
  return type != nullptr && type->is_string() ? type->get<std::string>() : "";
}

/// The steps of a "Sequence", or the one step that is there.
std::vector<const json*> steps_of(const json* step, const char* list) {
  if (step == nullptr || step->is_null()) return {};
  if (type_of(*step) != "Sequence") return {step};
  std::vector<const json*> steps;
  if (const json* inner = find(*step, list); inner != nullptr && inner->is_array())
    for (const json& one : *inner) steps.push_back(&one);
  return steps;
}

CharacterMap read_normaliser(const json& root, const std::string& path) {
  CharacterMap map;
  for (const json* step : steps_of(find(root, "normalizer"), "normalizers")) {
    const std::string type = type_of(*step);
    if (const json* bytes = find(*step, "precompiled_charsmap"); type == "Precompiled" && bytes != nullptr) {
      if (bytes->is_null()) continue;
      if (!bytes->is_string()) fail(ErrorCode::file_damaged, "{}: its character map is no string", path);
      map = CharacterMap(decode_base64(bytes->get_ref<const std::string&>(), path), path);
    } else if (type != "Replace" && type != "Strip") {
      // Those two only remove spaces that the split into words removes anyway.
      fail(ErrorCode::value_invalid, "{}: normalises by '{}'; 'Precompiled' is wanted, as T5's tokenizers do", path,
           type);
    }
  }
  return map;
}

void check_splitter(const json& root, const std::string& path) {
  bool marks_words = false;
  for (const json* step : steps_of(find(root, "pre_tokenizer"), "pretokenizers")) {
    const std::string type = type_of(*step);
    if (type != "WhitespaceSplit" && type != "Metaspace")
      fail(ErrorCode::value_invalid, "{}: splits by '{}'; 'WhitespaceSplit' and 'Metaspace' are wanted", path, type);
    marks_words = marks_words || type == "Metaspace";
  }
  if (!marks_words) fail(ErrorCode::value_invalid, "{}: has no 'Metaspace' among its pre_tokenizers", path);
}

UnigramModel read_model(const json& root, const std::string& path) {
  const json* model = find(root, "model");
  const json* vocabulary = model == nullptr ? nullptr : find(*model, "vocab");
  const json* unknown = model == nullptr ? nullptr : find(*model, "unk_id");
  if (vocabulary == nullptr || !vocabulary->is_array() || unknown == nullptr || !unknown->is_number_unsigned())
    fail(ErrorCode::value_invalid, "{}: has no unigram model with 'vocab' and 'unk_id'", path);
  std::vector<Piece> pieces;
  pieces.reserve(vocabulary->size());
  for (const json& entry : *vocabulary) {
    if (!entry.is_array() || entry.size() != 2 || !entry[0].is_string() || !entry[1].is_number())
      fail(ErrorCode::file_damaged, "{}: piece {} is no pair of a text and a score", path, pieces.size());
    pieces.push_back({entry[0].get<std::string>(), entry[1].get<double>()});
  }
  const json* fallback = find(*model, "byte_fallback");
  return {std::move(pieces),
          static_cast<std::int64_t>(std::min<std::uint64_t>(unknown->get<std::uint64_t>(), INT64_MAX)),
          fallback != nullptr && fallback->is_boolean() && fallback->get<bool>(), path};
}

std::vector<AddedToken> read_added_tokens(const json& root, const std::string& path) {
  std::vector<AddedToken> added;
  const json* list = find(root, "added_tokens");
  if (list == nullptr || !list->is_array()) return added;
  for (const json& token : *list) {
    const json* text = find(token, "content");
    const json* id = find(token, "id");
    if (text == nullptr || !text->is_string() || text->get_ref<const std::string&>().empty() || id == nullptr ||
        !id->is_number_unsigned() || id->get<std::uint64_t>() > INT32_MAX)
      fail(ErrorCode::file_damaged, "{}: added token {} has no 'content' or no 'id'", path, added.size());
    added.push_back({text->get<std::string>(), id->get<std::int64_t>()});
  }
  return added;
}

/// A special token's id: among those added, else among the pieces.
std::int64_t special_id(const TokenizerParts& parts, std::string_view text, const std::string& path) {
  for (const AddedToken& token : parts.added)
    if (token.text == text) return token.id;
  const auto piece = parts.model.id(text);
  if (!piece) fail(ErrorCode::value_invalid, "{}: has no token '{}'; is it a T5 tokenizer?", path, text);
  return *piece;
}

}  // namespace

TokenizerParts parse_tokenizer_json(std::string_view text, const std::string& path) {
  const json root = io::parse_json(text, path);
  TokenizerParts parts;
  parts.character_map = read_normaliser(root, path);
  check_splitter(root, path);
  parts.model = read_model(root, path);
  parts.added = read_added_tokens(root, path);
  parts.padding = special_id(parts, "<pad>", path);
  parts.end = special_id(parts, "</s>", path);
  return parts;
}

TokenizerParts read_tokenizer(const std::string& folder) {
  const fs::path base = folder;
  const std::string json_path = (base / "tokenizer.json").string();
  const std::string spiece_path = (base / "spiece.model").string();
  const std::string config_path = (base / "tokenizer_config.json").string();
  if (fs::exists(json_path)) return parse_tokenizer_json(io::read_text(json_path, max_file_bytes), json_path);
  if (!fs::exists(spiece_path))
    fail(ErrorCode::file_not_found,
         "{}: holds neither tokenizer.json nor spiece.model; the folder tokenizer/ of the "
         "model is wanted",
         folder);
  return parse_spiece_model(io::read_text(spiece_path, max_file_bytes), spiece_path,
                            fs::exists(config_path) ? io::read_text(config_path, max_file_bytes) : "", config_path);
}

}  // namespace uwv::model
