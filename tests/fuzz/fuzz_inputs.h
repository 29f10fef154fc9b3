// SPDX-License-Identifier: Apache-2.0
// What is done with bytes from outside to see whether a reader stands them: by libFuzzer (docs/model-text.md tells how
// to run it), and by the tests on tests/data/fuzz.
//
// Each function takes any bytes and returns, or throws uwv::Error, which is what a reader has to do with bad ones.
// Anything else is a finding.
#pragma once

#include <string_view>
#include <vector>

namespace uwv::testing {

/// A safetensors file: opened, and every tensor read.
void fuzz_safetensors(std::string_view bytes);
/// A model.safetensors.index.json beside two shards with tensors "a" and "b".
void fuzz_weight_index(std::string_view bytes);
/// A tokenizer.json, used to encode a few words.
void fuzz_tokenizer_json(std::string_view bytes);
/// A spiece.model, used so.
void fuzz_spiece_model(std::string_view bytes);
/// A prompt: cleaned and tokenized. The cleaned one has to be UTF-8.
void fuzz_prompt(std::string_view bytes);
/// Byte 0 chooses a config.json's reader (text encoder, transformer, autoencoder, scheduler), the rest is the file.
void fuzz_config(std::string_view bytes);

struct FuzzInput {
  const char* name;
  void (*run)(std::string_view bytes);
};
/// All of the above by name; the corpus of each is tests/data/fuzz/<name>.
const std::vector<FuzzInput>& fuzz_inputs();

}  // namespace uwv::testing
