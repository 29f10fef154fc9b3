// SPDX-License-Identifier: Apache-2.0
#include "model/text/prompt_cache.h"

#include <ATen/ATen.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "model/text/prompt_text.h"
#include "uwv/core/error.h"
#include "uwv/io/safetensors_writer.h"

namespace uwv::model {
namespace {

namespace fs = std::filesystem;

constexpr const char* tensor_name = "prompt_embeds";
constexpr const char* recipe_name = "recipe";

/// FNV-1a; only a file's name depends on it, the recipe inside is compared in full.
std::uint64_t hash_of(std::string_view text) {
  std::uint64_t hash = 0xCBF29CE484222325;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3;
  return hash;
}

/// One line for each file of a folder.
std::string contents_of(const std::string& folder) {
  std::vector<std::string> lines;
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(folder, failed))
    if (entry.is_regular_file(failed))
      lines.push_back(fmt::format("{} {} {}\n", entry.path().filename().string(), entry.file_size(failed),
                                  entry.last_write_time(failed).time_since_epoch().count()));
  std::sort(lines.begin(), lines.end());
  std::string text;
  for (const std::string& line : lines) text += line;
  return text;
}

}  // namespace

PromptCache PromptCache::of_user() {
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return std::string(value != nullptr ? value : "");
  };
  const std::string home = variable("HOME"), given = variable("XDG_CACHE_HOME");
  if (given.empty() && home.empty()) return PromptCache("");
  return PromptCache((given.empty() ? fs::path(home) / ".cache" : fs::path(given)) / "uwv" / "prompts");
}

std::string PromptCache::path_of(const std::string& recipe) const {
  return (fs::path(folder_) / fmt::format("{:016x}.safetensors", hash_of(recipe))).string();
}

std::optional<at::Tensor> PromptCache::find(const std::string& recipe, std::int64_t tokens) const {
  const std::string path = path_of(recipe);
  if (folder_.empty() || !fs::exists(path)) return std::nullopt;
  try {
    const SafeTensors file = SafeTensors::open(path);
    const auto told = file.metadata().find(recipe_name);
    if (told == file.metadata().end() || told->second != recipe || !file.has(tensor_name)) return std::nullopt;
    const std::vector<std::size_t>& shape = file.info(tensor_name).shape;
    if (shape.size() != 3 || shape[0] != 1 || shape[1] != static_cast<std::size_t>(tokens)) return std::nullopt;
    const at::Tensor embedding =
        at::tensor(file.as_float(tensor_name)).reshape({1, tokens, static_cast<std::int64_t>(shape[2])});
    if (!embedding.isfinite().all().item<bool>()) return std::nullopt;
    return embedding;
  } catch (const Error&) {
    // Damaged entries are made anew.
    return std::nullopt;
  }
}

void PromptCache::store(const std::string& recipe, const at::Tensor& embedding) const {
  if (folder_.empty()) return;
  std::error_code failed;
  fs::create_directories(folder_, failed);
  const at::Tensor whole = embedding.to(at::kFloat).contiguous();
  const std::string path = path_of(recipe);
  // A name of its own until it is whole: another process may be writing the same entry.
  const std::string own = fmt::format("{}.{}", path, ::getpid());
  const std::span values(whole.const_data_ptr<float>(), static_cast<std::size_t>(whole.numel()));
  write_safetensors(
      own, {{tensor_name, {{DType::f32, {whole.sizes().begin(), whole.sizes().end()}}, std::as_bytes(values)}}},
      {{recipe_name, recipe}});
  fs::rename(own, path, failed);
  if (failed) fail(ErrorCode::output_failed, "{}: cannot be renamed ({})", path, failed.message());
}

std::string PromptEncoding::recipe(const std::string& cleaned_prompt) const {
  return fmt::format("{}\nform {}\ntokens {}\nencoder\n{}tokenizer\n{}", cleaned_prompt, to_string(form), tokens,
                     contents_of(encoder_folder), contents_of(tokenizer_folder));
}

std::vector<at::Tensor> encode_prompts(const std::vector<std::string>& prompts, const PromptEncoding& encoding,
                                       const PromptCache& cache, Monitor& monitor) {
  std::vector<at::Tensor> embeddings;
  std::vector<std::string> recipes, missing;
  std::vector<std::size_t> places;
  for (const std::string& prompt : prompts) {
    const std::string cleaned = clean_prompt(prompt);
    recipes.push_back(encoding.recipe(cleaned));
    embeddings.push_back(cache.find(recipes.back(), encoding.tokens).value_or(at::Tensor()));
    if (embeddings.back().defined()) continue;
    missing.push_back(cleaned);
    places.push_back(embeddings.size() - 1);
  }
  if (missing.empty()) return embeddings;
  const auto encoder =
      TextEncoder::open(encoding.encoder_folder, encoding.tokenizer_folder, encoding.form, encoding.device);
  const std::vector<at::Tensor> encoded = encoder.encode(missing, monitor, encoding.tokens);
  for (std::size_t i = 0; i < places.size(); ++i) {
    embeddings[places[i]] = encoded[i];
    try {
      cache.store(recipes[places[i]], encoded[i]);
    } catch (const Error& error) {
      monitor.warn(fmt::format("the encoded prompt is not kept: {}", error.what()));
    }
  }
  return embeddings;
}

}  // namespace uwv::model
