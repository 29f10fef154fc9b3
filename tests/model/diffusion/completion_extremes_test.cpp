// SPDX-License-Identifier: Apache-2.0
// The whole way from frames to frames where parts meet that are tested apart elsewhere, and at the ends of what they
// take.
#include <ATen/ATen.h>
#include <gmock/gmock.h>

#include <filesystem>

#include "model/diffusion/completion_fixture.h"
#include "model/tensor_support.h"
#include "uwv/core/error.h"

namespace uwv {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using uwv::testing::write_safetensors;

using Tensors = std::map<std::string, at::Tensor>;

class CompletionExtremes : public CompletionTest {
 protected:
  CompletionExtremes() { at::manual_seed(6); }
  Tensors transformer_weights() const {
    const model::WeightFiles files = model::WeightFiles::open(options_.transformer);
    Tensors weights;
    for (const std::string& name : files.names()) weights[name] = files.load(name, at::kFloat);
    return weights;
  }
  /// A transformer of these weights with the settings of the fixture's.
  std::string written(const Tensors& weights, const std::string& name) const {
    const std::string folder = cache_.file(name);
    fs::create_directories(folder);
    fs::copy(options_.transformer + "/config.json", folder + "/config.json");
    write_safetensors(folder + "/diffusion_pytorch_model.safetensors", weights);
    return folder;
  }
};

TEST_F(CompletionExtremes, ALoraIsACheckpointWithItsProductsAdded) {
  constexpr double weight = 0.8;
  Tensors fused = transformer_weights(), lora;
  for (auto& [name, tensor] : fused) {
    const bool chosen = name.ends_with(".attn1.to_q.weight") || name.ends_with(".ffn.net.2.weight");
    if (!chosen) continue;
    const at::Tensor down = at::randn({2, tensor.size(1)}), up = at::randn({tensor.size(0), 2}) * 0.3;
    const std::string layer = "transformer." + name.substr(0, name.size() - std::string(".weight").size());
    lora[layer + ".lora_A.weight"] = down;
    lora[layer + ".lora_B.weight"] = up;
    tensor = tensor + weight * at::mm(up, down);
  }
  ASSERT_FALSE(lora.empty());
  options_.guidance = 4;
  const Answer without = complete({});
  options_.lora = {cache_.file("lora.safetensors") + ":0.8"};
  write_safetensors(cache_.file("lora.safetensors"), lora);
  const Answer with = complete({});
  options_.lora.clear();
  options_.transformer = written(fused, "fused");
  const Answer offline = complete({});
  EXPECT_GT(difference(with.frames, without.frames).largest, 2);
  EXPECT_LE(difference(with.frames, offline.frames).largest, 1);
}

TEST_F(CompletionExtremes, TwoThreadsGiveTheirBytesEachTimeAndThoseOfOneWithinALevel) {
  const Scene scene{.size = {32, 16}};
  const Answer one = complete(scene), two = complete(scene, options_, 2);
  EXPECT_EQ(complete(scene, options_, 2).frames, two.frames);
  EXPECT_LE(difference(one.frames, two.frames).largest, 1);
}

TEST_F(CompletionExtremes, EverySamplerGoesFromNoiseToNoneInOneStepAndAtTheEndsOfTheShift) {
  using enum model::SamplerKind;
  for (const model::SamplerKind kind : {euler, euler_plain, unipc, unipc_legacy, dpmpp})
    for (const auto& [steps, shift] : {std::pair(1, 5.0), std::pair(3, 100.0), std::pair(3, 0.01)}) {
      SCOPED_TRACE(fmt::format("{} {} {}", to_string(kind), steps, shift));
      options_.sampler = kind;
      options_.steps = steps;
      options_.shift = shift;
      options_.guidance = 1;
      EXPECT_TRUE(complete({.size = {16, 16}, .frames = 5, .holes = Holes::all}).summary.model_was_run);
    }
}

TEST_F(CompletionExtremes, MoreThanAHundredFramesGoThroughSeveralWindows) {
  options_.steps = 1;
  const Answer answer = complete({.size = {16, 16}, .frames = 119});
  EXPECT_EQ(answer.summary.windows, 2);
  options_.window_frames = 41;
  EXPECT_GT(complete({.size = {16, 16}, .frames = 119}).summary.windows, 4);
}

/// Stops at the second report of one stage.
class StopIn : public Monitor {
 public:
  explicit StopIn(std::string stage) : stage_(std::move(stage)) {}
  bool progress(std::string_view stage, long, long) override { return stage != stage_ || ++reports_ < 2; }

 private:
  std::string stage_;
  int reports_ = 0;
};

TEST_F(CompletionExtremes, StoppedInAnyStageTheNextRunGivesWhatAnUndisturbedOneDoes) {
  const Scene scene;
  CompletedClip nowhere;
  nowhere.write = [](long, const ImageRgb&) {};
  for (const char* stage : {"vae encode", "text encoder", "denoising", "vae decode"}) {
    StopIn stop(stage);
    uwv::testing::complaint([&] { complete_views(options_, scene.clip(), nowhere, 1, stop); }, ErrorCode::cancelled);
  }
  const Answer after = complete(scene);
  options_.prompt_cache = cache_.file("prompts never stopped");
  EXPECT_EQ(complete(scene).frames, after.frames);
}

TEST_F(CompletionExtremes, PromptsOfNothingOfEmojiAndOfTwoThousandWordsReachTheFrames) {
  std::string long_prompt;
  for (int i = 0; i < 2000; ++i) long_prompt += "snow ";
  std::vector<std::vector<ImageRgb>> seen;
  for (const std::string& prompt :
       {std::string(), std::string("\U0001F407\u2744\uFE0F\U0001F468‍\U0001F680"), long_prompt}) {
    options_.prompt = prompt;
    seen.push_back(complete({}).frames);
  }
  EXPECT_NE(seen[0], seen[1]);
  EXPECT_NE(seen[1], seen[2]);
}

TEST_F(CompletionExtremes, NumbersBeyondFloatsRangeNameTheBlockInEveryForm) {
  Tensors weights = transformer_weights();
  for (auto& [name, tensor] : weights)
    if (name.starts_with("blocks.1.ffn.")) tensor = tensor * 1e25;
  options_.transformer = written(weights, "blown up");
  for (const WeightsForm form : {WeightsForm::f32, WeightsForm::bf16_stored, WeightsForm::bf16, WeightsForm::int8}) {
    options_.weights = form;
    EXPECT_THAT(complaint(options_), HasSubstr("no longer finite after block 1"));
  }
}

}  // namespace
}  // namespace uwv
