// SPDX-License-Identifier: Apache-2.0
#include "model/text/text_encoder.h"

#include <ATen/ATen.h>

#include "uwv/core/error.h"

namespace uwv::model {

TextEncoder TextEncoder::open(const std::string& encoder_folder, const std::string& tokenizer_folder, LinearForm form,
                              c10::Device device) {
  TextEncoder text(Tokenizer::open(tokenizer_folder), Umt5Encoder::open(encoder_folder, form, device));
  if (text.tokenizer_.ids() > text.encoder_.config().vocabulary)
    fail(ErrorCode::value_invalid,
         "{}: gives {} different ids, but the text encoder in {} knows {}; they are not of "
         "one model",
         tokenizer_folder, text.tokenizer_.ids(), encoder_folder, text.encoder_.config().vocabulary);
  return text;
}

std::vector<at::Tensor> TextEncoder::encode(const std::vector<std::string>& prompts, Monitor& monitor,
                                            std::int64_t length) const {
  std::vector<TokenBatch> batches;
  for (const std::string& prompt : prompts) {
    Tokens tokens = tokenizer_.encode(prompt, static_cast<std::size_t>(length));
    // Padding is masked out everywhere: without it the text's vectors are the same, and far quicker to have.
    tokens.ids.resize(tokens.length());
    const at::Tensor ids = at::tensor(tokens.ids, at::kLong).unsqueeze(0);
    batches.push_back({ids, at::ones_like(ids)});
  }
  const auto hidden = encoder_.encode(
      batches, [&](std::int64_t done, std::int64_t total, const auto&) { monitor.step("text encoder", done, total); });
  std::vector<at::Tensor> padded;
  for (const at::Tensor& h : hidden) {
    padded.push_back(at::zeros({1, length, width()}));
    padded.back().narrow(1, 0, h.size(1)).copy_(h);
  }
  return padded;
}

}  // namespace uwv::model
