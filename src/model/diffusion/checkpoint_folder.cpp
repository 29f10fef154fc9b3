// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/checkpoint_folder.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>

namespace uwv::model {
namespace {

namespace fs = std::filesystem;

/// A folder of the checkpoint with its settings, or "".
std::string part(const fs::path& root, const char* name, const char* settings) {
  return fs::exists(root / name / settings) ? (root / name).string() : std::string();
}

/// "FILE:WEIGHT" or "FILE"; a colon that no number follows belongs to the name.
std::pair<std::string, double> split_lora(const std::string& text) {
  std::pair<std::string, double> lora{text, 1};
  const auto colon = text.rfind(':');
  char* end = nullptr;
  const char* number = colon == std::string::npos ? "" : text.c_str() + colon + 1;
  const double weight = std::strtod(number, &end);
  if (end != number && *end == '\0') lora = {text.substr(0, colon), weight};
  if (!(std::abs(lora.second) <= 100))
    fail(ErrorCode::value_invalid, "--lora {}: found weight {}, wanted -100 to 100", text, lora.second);
  if (!fs::is_regular_file(lora.first)) fail(ErrorCode::file_not_found, "--lora {}: no such file", lora.first);
  return lora;
}

}  // namespace

CheckpointFolder CheckpointFolder::find(const ModelOptions& options) {
  const fs::path root(options.model);
  if (!fs::is_directory(root))
    fail(ErrorCode::file_not_found, "--model {}: no such folder; wanted a checkpoint laid out as docs/model.md tells",
         options.model);
  CheckpointFolder found;
  found.transformer = options.transformer.empty() ? part(root, "transformer", "config.json") : options.transformer;
  if (found.transformer.empty() || !fs::exists(fs::path(found.transformer) / "config.json"))
    fail(ErrorCode::file_not_found,
         "--model {}: no transformer/config.json in it; a transformer that lies elsewhere is named by --transformer",
         options.transformer.empty() ? options.model : options.transformer);
  found.vae = part(root, "vae", "config.json");
  if (found.vae.empty())
    fail(ErrorCode::file_not_found,
         "--model {}: no vae/config.json in it; take the folder vae of the checkpoint that the transformer builds on",
         options.model);
  found.text_encoder = part(root, "text_encoder", "config.json");
  found.tokenizer = fs::is_directory(root / "tokenizer") ? (root / "tokenizer").string() : std::string();
  if (found.text_encoder.empty() != found.tokenizer.empty())
    fail(ErrorCode::file_not_found, "--model {}: {} is missing; text_encoder and tokenizer are needed together",
         options.model, found.tokenizer.empty() ? "tokenizer/" : "text_encoder/config.json");
  if (found.text_encoder.empty() && options.prompt_embeds.empty())
    fail(ErrorCode::file_not_found,
         "--model {}: neither text_encoder/ nor tokenizer/ is in it; add them, or name encoded prompts by "
         "--prompt-embeds",
         options.model);
  const fs::path scheduler = root / "scheduler" / "scheduler_config.json";
  if (fs::exists(scheduler)) found.scheduler_config = scheduler.string();
  if (!options.prompt_embeds.empty() && !fs::is_regular_file(options.prompt_embeds))
    fail(ErrorCode::file_not_found, "--prompt-embeds {}: no such file", options.prompt_embeds);
  if (!options.vae_fast.empty() && !fs::exists(options.vae_fast))
    fail(ErrorCode::file_not_found, "--vae-fast {}: no such file or folder", options.vae_fast);
  for (const std::string& lora : options.lora) found.loras.push_back(split_lora(lora));
  return found;
}

}  // namespace uwv::model
