// SPDX-License-Identifier: Apache-2.0
#include "fuzz/fuzz_inputs.h"

#include <stdexcept>

#include "model/sampling/scheduler_config.h"
#include "model/text/prompt_text.h"
#include "model/text/tokenizer.h"
#include "model/text/umt5_encoder.h"
#include "model/text/utf8.h"
#include "model/transformer/transformer_config.h"
#include "model/vae/vae_config.h"
#include "model/weights/weight_files.h"
#include "support/temp_folder.h"
#include "uwv/io/safetensors.h"

namespace uwv::testing {
namespace {

void use(const model::TokenizerParts& parts) {
  const model::Tokenizer tokenizer(parts);
  const std::string words = "a caf\xC3\xA9 </s> e\xCC\x81 <extra_id_0>\xE2\x96\x81z \xF0\x9F\x9A\x80";
  if (tokenizer.encode(words, 16).ids.size() != 16) throw std::logic_error("not padded");
}

}  // namespace

void fuzz_safetensors(std::string_view bytes) {
  static const test::TempFolder folder;
  const SafeTensors file = SafeTensors::open(folder.write("f.safetensors", bytes));
  for (const std::string& name : file.names())
    if (file.as_double(name).size() != file.info(name).values()) throw std::logic_error("values are missing");
  // As tensors, too: their sizes are signed.
  const auto weights = model::WeightFiles::open(folder.file("f.safetensors"));
  for (const std::string& name : weights.names()) {
    const DType type = weights.info(name).dtype;
    if (type != DType::u16 && type != DType::u32 && type != DType::u64) (void)weights.view(name);
  }
}

void fuzz_weight_index(std::string_view bytes) {
  static const test::TempFolder folder;
  static const bool shards_written = [] {
    for (const std::string name : {"a", "b"}) {
      const std::string header = "{\"" + name + R"(":{"dtype":"F32","shape":[1],"data_offsets":[0,4]}})";
      // 8 bytes tell the header's length, which one can.
      std::string shard(8, '\0');
      shard[0] = static_cast<char>(header.size());
      folder.write(name + ".safetensors", shard.append(header).append("1234"));
    }
    return true;
  }();
  if (!shards_written) return;
  folder.write("model.safetensors.index.json", bytes);
  (void)model::WeightFiles::open(folder.path().string());
}

void fuzz_tokenizer_json(std::string_view bytes) { use(model::parse_tokenizer_json(bytes, "tokenizer.json")); }

void fuzz_spiece_model(std::string_view bytes) {
  use(model::parse_spiece_model(bytes, "spiece.model", "", "tokenizer_config.json"));
}

void fuzz_prompt(std::string_view bytes) {
  static const auto tokenizer = model::Tokenizer::open(std::string(UWV_TEST_DATA) + "/text/tokenizer");
  const std::string cleaned = model::clean_prompt(bytes);
  if (model::valid_utf8(cleaned) != cleaned) throw std::logic_error("a cleaned prompt is not UTF-8");
  for (const std::int64_t id : tokenizer.encode(cleaned, 64).ids)
    if (id < 0 || id >= tokenizer.ids()) throw std::logic_error("an id is out of range");
  (void)tokenizer.encode(bytes);
}

void fuzz_config(std::string_view bytes) {
  static const test::TempFolder folder;
  if (bytes.empty()) return;
  const std::string path = folder.write("config.json", bytes.substr(1));
  switch (bytes[0] & 3) {
    case 0: (void)model::Umt5Config::read(path); break;
    case 1: (void)model::TransformerConfig::read(folder.path().string()); break;
    case 2: (void)model::VaeConfig::read(path); break;
    default: (void)model::read_scheduler_config(path); break;
  }
}

const std::vector<FuzzInput>& fuzz_inputs() {
  static const std::vector<FuzzInput> inputs{{"safetensors", fuzz_safetensors},
                                             {"weight_index", fuzz_weight_index},
                                             {"tokenizer_json", fuzz_tokenizer_json},
                                             {"spiece_model", fuzz_spiece_model},
                                             {"prompt", fuzz_prompt},
                                             {"config", fuzz_config}};
  return inputs;
}

}  // namespace uwv::testing
