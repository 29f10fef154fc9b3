// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/prompt_embeddings.h"

#include <ATen/ATen.h>

#include "model/text/prompt_cache.h"

namespace uwv::model {
namespace {

at::Tensor read_embedding(const WeightFiles& file, const char* name) {
  at::Tensor tokens = file.load(name, at::kFloat);
  if (tokens.dim() == 2) tokens = tokens.unsqueeze(0);
  if (tokens.dim() != 3 || tokens.size(0) != 1 || tokens.size(1) < 1)
    fail(ErrorCode::value_invalid,
         "{}: '{}' has {} dimensions, the first of {}, wanted (tokens, width) or (1, tokens, "
         "width)",
         file.path(), name, tokens.dim(), tokens.dim() > 0 ? tokens.size(0) : 0);
  if (!at::isfinite(tokens).all().item<bool>())
    fail(ErrorCode::value_invalid, "{}: '{}' holds values that are no numbers", file.path(), name);
  return tokens;
}

PromptEmbeddings read_embeddings(const std::string& path, bool with_negative) {
  const WeightFiles file = WeightFiles::open(path);
  if (!file.has("prompt_embeds") || (with_negative && !file.has("negative_prompt_embeds")))
    fail(ErrorCode::value_invalid, "--prompt-embeds {}: found no tensor '{}'{}", path,
         file.has("prompt_embeds") ? "negative_prompt_embeds" : "prompt_embeds",
         file.has("prompt_embeds") ? "; add it, or pass --guidance 1, which needs none" : "");
  return {read_embedding(file, "prompt_embeds"),
          with_negative ? read_embedding(file, "negative_prompt_embeds") : at::Tensor()};
}

}  // namespace

PromptEmbeddings embed_prompts(const ModelOptions& options, const CheckpointFolder& folder, bool with_negative,
                               c10::Device device, Monitor& monitor) {
  if (!options.prompt_embeds.empty()) return read_embeddings(options.prompt_embeds, with_negative);
  std::vector<std::string> prompts{options.prompt};
  if (with_negative) prompts.push_back(options.negative_prompt);
  const PromptCache cache = options.prompt_cache.empty() ? PromptCache::of_user() : PromptCache(options.prompt_cache);
  PromptEncoding encoding{folder.text_encoder, folder.tokenizer};
  encoding.device = device;
  const std::vector<at::Tensor> encoded = encode_prompts(prompts, encoding, cache, monitor);
  return {encoded[0], with_negative ? encoded[1] : at::Tensor()};
}

}  // namespace uwv::model
