// SPDX-License-Identifier: Apache-2.0
// The text encoder against transformers' UMT5EncoderModel in float32, layer by layer.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "model/layers/torch_scope.h"
#include "model/tensor_support.h"
#include "model/text/umt5_encoder.h"
#include "support/matchers.h"
#include "support/temp_folder.h"

namespace uwv::model {
namespace {

namespace fs = std::filesystem;
using uwv::testing::near;

/// Twice what the golden run in float32 differs from one in float64, by the fixtures' README, and a rounding.
constexpr double tolerance = 1e-5;

std::vector<fs::path> cases() {
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(testing::fixture_folder("text/text_encoder")))
    if (entry.path().filename().string().starts_with("case_")) found.push_back(entry.path());
  return found;
}

void expect_golden(const Umt5Encoder& encoder, const fs::path& path) {
  SCOPED_TRACE(path.filename());
  const WeightFiles golden = WeightFiles::open(path.string());
  const TokenBatch batch{golden.view("input_ids"), golden.view("attention_mask")};
  int layers_seen = 0;
  const auto after_layer = [&](std::int64_t done, std::int64_t total, const std::vector<at::Tensor>& hidden) {
    ++layers_seen;
    const std::string name = "hidden_" + std::to_string(done);
    // The golden of the last layer is taken after the final norm.
    if (done < total) {
      EXPECT_TRUE(near(hidden.front(), golden.view(name), tolerance)) << name;
    }
  };
  const at::Tensor last = encoder.encode({batch}, after_layer).front();
  EXPECT_EQ(layers_seen, encoder.config().layers + 1);
  EXPECT_TRUE(near(last, golden.view("last_hidden_state"), tolerance));
  EXPECT_TRUE(near(last * batch.mask.unsqueeze(-1), golden.view("prompt_embeds"), tolerance));
}

TEST(Umt5Parity, EveryLayerGivesTheNumbersOfTransformers) {
  const TorchScope scope(1);
  ASSERT_FALSE(cases().empty());
  const Umt5Encoder encoder = Umt5Encoder::open(testing::fixture_folder("text/text_encoder"), LinearForm::f32);
  for (const fs::path& path : cases()) expect_golden(encoder, path);
}

TEST(Umt5Parity, ShardsGiveTheSame) {
  const TorchScope scope(2);
  const Umt5Encoder encoder = Umt5Encoder::open(testing::fixture_folder("text/text_encoder_sharded"), LinearForm::f32);
  for (const fs::path& path : cases()) expect_golden(encoder, path);
}

TEST(Umt5Parity, BucketsAreThoseOfTheReference) {
  const WeightFiles golden =
      WeightFiles::open(testing::fixture_folder("text/text_encoder") + "/relative_buckets.safetensors");
  const Umt5Config config = Umt5Config::read(testing::fixture_folder("text/text_encoder") + "/config.json");
  EXPECT_TRUE(at::equal(relative_buckets(golden.view("relative_position"), config.buckets, config.max_distance),
                        golden.view("bucket")));
}

TEST(Umt5Parity, WeightsStoredInHalfAsManyBitsComputeAsTheirRoundedValues) {
  const TorchScope scope(1);
  const std::string folder = testing::fixture_folder("text/text_encoder");
  const WeightFiles exact = WeightFiles::open(folder + "/model.safetensors");
  std::map<std::string, at::Tensor> stored, rounded;
  for (const std::string& name : exact.names()) {
    stored[name] = exact.view(name).to(at::kBFloat16);
    rounded[name] = stored[name].to(at::kFloat);
  }
  const test::TempFolder small, large;
  for (const auto& [target, tensors] : {std::pair(&small, &stored), std::pair(&large, &rounded)}) {
    fs::copy_file(folder + "/config.json", target->path() / "config.json");
    testing::write_safetensors(target->file("model.safetensors"), *tensors);
  }
  const WeightFiles golden = WeightFiles::open(cases().front().string());
  const TokenBatch batch{golden.view("input_ids"), golden.view("attention_mask")};
  const at::Tensor wanted = Umt5Encoder::open(large.path().string(), LinearForm::f32).encode({batch}, nullptr).front();
  for (const LinearForm form : {LinearForm::f32, LinearForm::bf16_stored})
    EXPECT_TRUE(near(Umt5Encoder::open(small.path().string(), form).encode({batch}, nullptr).front(), wanted, 0));
}

TEST(Umt5Parity, TheNamesOfWansOwnReleaseAreKnown) {
  const TorchScope scope(1);
  const std::map<std::string, std::string> theirs{
      {"0.layer_norm", "norm1"},
      {"0.SelfAttention.q", "attn.q"},
      {"0.SelfAttention.k", "attn.k"},
      {"0.SelfAttention.v", "attn.v"},
      {"0.SelfAttention.o", "attn.o"},
      {"0.SelfAttention.relative_attention_bias", "pos_embedding.embedding"},
      {"1.layer_norm", "norm2"},
      {"1.DenseReluDense.wi_0", "ffn.gate.0"},
      {"1.DenseReluDense.wi_1", "ffn.fc1"},
      {"1.DenseReluDense.wo", "ffn.fc2"}};
  const WeightFiles official = WeightFiles::open(testing::fixture_folder("text/text_encoder") + "/model.safetensors");
  std::map<std::string, at::Tensor> original;
  for (const std::string& name : official.names()) {
    std::string other = name == "shared.weight" ? "token_embedding.weight" : "norm.weight";
    if (name.starts_with("encoder.block.")) {
      const std::size_t dot = name.find('.', 14), part = dot + std::string(".layer.").size();
      other = "blocks." + name.substr(14, dot - 14) + "." +
              theirs.at(name.substr(part, name.size() - part - std::string(".weight").size())) + ".weight";
    }
    original[other] = official.view(name);
  }
  const test::TempFolder folder;
  const std::string path = folder.file("models_t5_umt5.safetensors");
  testing::write_safetensors(path, original);
  // Alone, it shows all sizes but the distance that the buckets end at.
  const Umt5Config shown = Umt5Encoder::open(path, LinearForm::f32).config();
  const std::string config = testing::fixture_folder("text/text_encoder") + "/config.json";
  EXPECT_EQ(shown.shapes(), Umt5Config::read(config).shapes());
  EXPECT_EQ(shown.max_distance, 128);
  fs::copy_file(config, folder.path() / "config.json");
  const Umt5Encoder encoder = Umt5Encoder::open(folder.path().string(), LinearForm::f32);
  for (const fs::path& golden : cases()) expect_golden(encoder, golden);
}

}  // namespace
}  // namespace uwv::model
