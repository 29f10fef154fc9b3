// SPDX-License-Identifier: Apache-2.0
#include "model/text/text_encoder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "model/layers/torch_scope.h"
#include "model/tensor_support.h"
#include "model/text/prompt_text.h"
#include "support/matchers.h"
#include "support/temp_folder.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

namespace fs = std::filesystem;
using uwv::testing::near;

TextEncoder tiny_encoder() {
  return TextEncoder::open(testing::fixture_folder("text/text_encoder"), testing::fixture_folder("text/tokenizer"),
                           LinearForm::f32);
}

TEST(TextEncoderParity, PromptsBecomeWhatTheOfficialPipelineMadeOfThem) {
  const TorchScope scope(1);
  const fs::path pipeline = testing::fixture_folder("pipeline");
  const TextEncoder encoder =
      TextEncoder::open(pipeline / "wan/text_encoder", pipeline / "wan/tokenizer", LinearForm::f32);
  Monitor monitor;
  int compared = 0;
  for (const auto& entry : fs::directory_iterator(pipeline)) {
    if (!fs::exists(entry.path() / "call.json")) continue;
    const auto call = nlohmann::json::parse(std::ifstream(entry.path() / "call.json"));
    const WeightFiles golden = WeightFiles::open((entry.path() / "case.safetensors").string());
    for (const auto& [text, tensor] :
         {std::pair("prompt", "prompt_embeds"), std::pair("negative_prompt", "negative_prompt_embeds")}) {
      if (!call.contains(text) || !call.at(text).is_string() || !golden.has(tensor)) continue;
      const std::string prompt = clean_prompt(call.at(text).get<std::string>());
      const at::Tensor ours = encoder.encode({prompt}, monitor, golden.shape(tensor)[1]).front();
      EXPECT_TRUE(near(ours, golden.view(tensor), 1e-5)) << entry.path() << " " << text;
      ++compared;
    }
  }
  EXPECT_GT(compared, 0);
}

TEST(TextEncoder, PromptsOfAnyLengthGiveFiniteNumbersAndZerosPastTheText) {
  const TorchScope scope(1);
  const TextEncoder encoder = tiny_encoder();
  Monitor monitor;
  std::string two_thousand_words;
  for (int i = 0; i < 2000; ++i) two_thousand_words += "word ";
  for (const std::string& prompt : {std::string(), std::string("\U0001F680\U0001F600\u2764\uFE0F"), two_thousand_words,
                                    std::string("a\0b", 3), std::string("\xFF\xFE broken")}) {
    const at::Tensor embedding = encoder.encode({prompt}, monitor).front();
    EXPECT_EQ(embedding.sizes(), (at::IntArrayRef{1, TextEncoder::prompt_tokens, encoder.width()}));
    EXPECT_TRUE(embedding.isfinite().all().item<bool>());
    // Row 0 is text: at least the end token.
    EXPECT_GT(embedding[0][0].abs().sum().item<float>(), 0);
    EXPECT_EQ(embedding[0][-1].abs().sum().item<float>() == 0, prompt != two_thousand_words);
  }
  EXPECT_THROW(encoder.encode({std::string(10'000'000, 'a')}, monitor), Error);
}

TEST(TextEncoder, EncodingTogetherOrAloneIsTheSame) {
  const TorchScope scope(1);
  const TextEncoder encoder = tiny_encoder();
  Monitor monitor;
  const std::string first = "a cat", second = "a long prompt about a white rabbit";
  const auto together = encoder.encode({first, second}, monitor);
  EXPECT_TRUE(at::equal(together[0], encoder.encode({first}, monitor).front()));
  EXPECT_TRUE(at::equal(together[1], encoder.encode({second}, monitor).front()));
}

TEST(TextEncoder, StopsAfterALayerWhenAskedTo) {
  class Stopping : public Monitor {
   public:
    bool progress(std::string_view, long done, long) override { return (seen = done) < 1; }
    long seen = -1;
  };
  const TorchScope scope(1);
  Stopping monitor;
  try {
    tiny_encoder().encode({"a"}, monitor);
    ADD_FAILURE() << "was not stopped";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::cancelled);
  }
  EXPECT_EQ(monitor.seen, 1);
}

/// The tiny encoder with one of its tensors replaced.
class ChangedEncoder {
 public:
  ChangedEncoder(const std::string& name, const std::function<at::Tensor(const at::Tensor&)>& change) {
    const std::string source = testing::fixture_folder("text/text_encoder");
    const WeightFiles weights = WeightFiles::open(source);
    std::map<std::string, at::Tensor> tensors;
    for (const std::string& n : weights.names()) tensors[n] = n == name ? change(weights.view(n)) : weights.view(n);
    fs::copy_file(source + "/config.json", folder_.path() / "config.json");
    testing::write_safetensors(folder_.file("model.safetensors"), tensors);
  }
  std::string path() const { return folder_.path().string(); }

 private:
  test::TempFolder folder_;
};

TEST(TextEncoder, NumbersThatAreNotFiniteNameTheLayer) {
  const TorchScope scope(1);
  const ChangedEncoder changed("encoder.block.1.layer.1.DenseReluDense.wo.weight",
                               [](const at::Tensor& t) { return t * std::numeric_limits<float>::max(); });
  Monitor monitor;
  try {
    TextEncoder::open(changed.path(), testing::fixture_folder("text/tokenizer"), LinearForm::f32)
        .encode({"a"}, monitor);
    ADD_FAILURE() << "was accepted";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("layer 1 "));
  }
}

TEST(TextEncoder, WeightsOfOtherShapesAndOtherTokenizersAreRefused) {
  const ChangedEncoder changed("encoder.block.0.layer.0.SelfAttention.q.weight",
                               [](const at::Tensor& t) { return t.narrow(0, 1, t.size(0) - 1).clone(); });
  EXPECT_THROW(Umt5Encoder::open(changed.path(), LinearForm::f32), Error);
  // A tokenizer with one id too many.
  const std::string text = testing::fixture_folder("text");
  auto tokenizer = nlohmann::json::parse(std::ifstream(text + "/tokenizer/tokenizer.json"));
  const auto rows = Umt5Config::read(text + "/text_encoder/config.json").vocabulary;
  tokenizer["added_tokens"].push_back({{"id", rows}, {"content", "<one_more>"}});
  const test::TempFolder folder;
  testing::write_text(folder.file("tokenizer.json"), tokenizer.dump());
  EXPECT_THROW(TextEncoder::open(text + "/text_encoder", folder.path().string(), LinearForm::f32), Error);
}

TEST(TextEncoder, FewerBitsStayNearTheExactAnswer) {
  const TorchScope scope(1);
  Monitor monitor;
  const std::string prompt = "a white rabbit with pink eyes";
  const at::Tensor exact = tiny_encoder().encode({prompt}, monitor).front();
  for (const LinearForm form : {LinearForm::bf16_stored, LinearForm::bf16, LinearForm::int8_stored, LinearForm::int8}) {
    const TextEncoder encoder = TextEncoder::open(testing::fixture_folder("text/text_encoder"),
                                                  testing::fixture_folder("text/tokenizer"), form);
    const at::Tensor error = encoder.encode({prompt}, monitor).front() - exact;
    const double relative = error.norm().item<double>() / exact.norm().item<double>();
    RecordProperty(to_string(form), std::to_string(relative));
    EXPECT_LT(relative, 0.1) << to_string(form);
  }
}

}  // namespace
}  // namespace uwv::model
