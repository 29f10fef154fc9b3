// SPDX-License-Identifier: Apache-2.0
// Encoded prompts kept on disk, so that an encoder of 11 GB is read once for each prompt.
//
// An entry is a safetensors file with the tensor "prompt_embeds", fit for --prompt-embeds too. Its metadata tells in
// full what it was made of; an entry that tells otherwise, or is damaged, is made anew.
#pragma once

#include <ATen/core/Tensor.h>

#include <optional>
#include <string>
#include <vector>

#include "model/text/text_encoder.h"
#include "uwv/core/monitor.h"

namespace uwv::model {

class PromptCache {
 public:
  /// `folder` need not exist yet; empty: nothing is kept.
  explicit PromptCache(std::string folder) : folder_(std::move(folder)) {}
  /// $XDG_CACHE_HOME/uwv/prompts, else ~/.cache/uwv/prompts, else (without a home) nothing is kept.
  static PromptCache of_user();

  const std::string& folder() const { return folder_; }
  /// Where the entry of `recipe` lies.
  std::string path_of(const std::string& recipe) const;
  /// The tensor kept under `recipe` if it is whole, finite, and of `tokens` rows: (1, tokens, width) float32.
  std::optional<at::Tensor> find(const std::string& recipe, std::int64_t tokens) const;
  /// Keeps a tensor. Another process may do so at the same time. Throws Error(output_failed).
  void store(const std::string& recipe, const at::Tensor& embedding) const;

 private:
  std::string folder_;
};

/// Where prompts are encoded, and how.
struct PromptEncoding {
  std::string encoder_folder, tokenizer_folder;
  LinearForm form = LinearForm::f32;
  std::int64_t tokens = TextEncoder::prompt_tokens;
  c10::Device device = c10::kCPU;  ///< Where the encoder runs; the answer is the same to rounding, and kept as one.

  /// Tells an encoding of a cleaned prompt from every other: the prompt, the form, the number of tokens, and name, size
  /// and time of change of each file in both folders.
  std::string recipe(const std::string& cleaned_prompt) const;
};

/// Cleans and encodes prompts: (1, tokens, width) float32 each, zeros past the text. The encoder is opened only if one
/// of them is not in the cache, and is gone when this returns. A cache that cannot be written to is a warning.
std::vector<at::Tensor> encode_prompts(const std::vector<std::string>& prompts, const PromptEncoding& encoding,
                                       const PromptCache& cache, Monitor& monitor);

}  // namespace uwv::model
