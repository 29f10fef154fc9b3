// SPDX-License-Identifier: Apache-2.0
// From a prompt to what the transformer reads of it: cleaned, tokenized, encoded, padded with zeros. Sheet model.md, 4.
#pragma once

#include <ATen/core/Tensor.h>

#include <string>
#include <vector>

#include "model/text/tokenizer.h"
#include "model/text/umt5_encoder.h"
#include "uwv/core/monitor.h"

namespace uwv::model {

class TextEncoder {
 public:
  /// Tokens that the transformer reads of a prompt, padding included; the official pipeline's number.
  static constexpr std::int64_t prompt_tokens = 512;

  /// The folders text_encoder/ and tokenizer/ of a model. Throws Error as Umt5Encoder and Tokenizer do, and
  /// value_invalid when the two do not belong together.
  static TextEncoder open(const std::string& encoder_folder, const std::string& tokenizer_folder, LinearForm form,
                          c10::Device device = c10::kCPU);

  std::int64_t width() const { return encoder_.config().d_model; }
  const Umt5Encoder& encoder() const { return encoder_; }

  /// Each cleaned prompt as (1, tokens, width) float32, on the CPU, zeros past its end token; longer prompts are cut.
  /// All are encoded in one walk through the weights, and only the tokens that are there. The monitor hears of stage
  /// "text encoder" after each layer and can stop it.
  std::vector<at::Tensor> encode(const std::vector<std::string>& prompts, Monitor& monitor,
                                 std::int64_t tokens = prompt_tokens) const;

 private:
  TextEncoder(Tokenizer tokenizer, Umt5Encoder encoder)
      : tokenizer_(std::move(tokenizer)), encoder_(std::move(encoder)) {}

  Tokenizer tokenizer_;
  Umt5Encoder encoder_;
};

}  // namespace uwv::model
