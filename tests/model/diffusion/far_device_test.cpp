// SPDX-License-Identifier: Apache-2.0
// Every part of the model on a device that is not the CPU, against the CPU. See far_device.h.
#include <ATen/ATen.h>
#include <gmock/gmock.h>

#include "model/diffusion/completion_fixture.h"
#include "model/far_device.h"
#include "model/layers/torch_scope.h"
#include "model/text/text_encoder.h"
#include "model/transformer/tiny_model.h"
#include "model/transformer/transformer_support.h"
#include "model/vae/tiny_vae.h"
#include "model/vae/wan_vae.h"

namespace uwv::model {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using uwv::testing::far_device;
using uwv::testing::fixture_folder;
using uwv::testing::near;

class FarDeviceParts : public ::testing::Test {
 protected:
  FarDeviceParts() { at::manual_seed(4); }
  TorchScope scope_{1};
  Monitor monitor_;
};

TEST_F(FarDeviceParts, EveryTransformerGivesTheCpusVelocity) {
  for (const std::string& name : uwv::testing::transformers()) {
    const std::string folder = fixture_folder("transformer/" + name);
    for (const std::string& path : uwv::testing::cases_in(folder)) {
      SCOPED_TRACE(path);
      const uwv::testing::GoldenCase golden(path);
      if (golden.is_bf16()) continue;
      const at::Tensor want = golden.run(WanTransformer::open(folder, {}));
      for (const bool streamed : {false, true}) {
        TransformerOptions options;
        options.device = far_device;
        options.streamed = streamed;
        const at::Tensor ours = golden.run(WanTransformer::open(folder, options));
        EXPECT_EQ(ours.device(), far_device);
        EXPECT_TRUE(near(ours.cpu(), want, 1e-5 * std::max(1.0, uwv::testing::rms(want))));
      }
    }
  }
}

TEST_F(FarDeviceParts, EveryFormOfWeightsGivesTheCpusVelocityAlsoFromTheStepCache) {
  const uwv::testing::TinyModel model;
  const uwv::testing::TinyInputs inputs;
  const auto run = [&](LinearForm form, c10::Device device) {
    TransformerOptions options;
    options.form = form;
    options.device = device;
    options.ffn_rows = 5;
    const WanTransformer network = model.open(options);
    TransformerContext context = network.prepare(inputs.control, inputs.reference, inputs.text);
    TransformerHooks hooks;
    hooks.inspect = [](const std::string&, const at::Tensor&) {};
    hooks.skip_blocks = [](const at::Tensor&) { return true; };
    network.forward(context, inputs.latents, inputs.timestep, hooks);
    return network.forward(context, inputs.latents, inputs.timestep + 20, hooks).cpu();
  };
  for (const LinearForm form : {LinearForm::f32, LinearForm::bf16_stored, LinearForm::int8_stored})
    EXPECT_TRUE(near(run(form, far_device), run(form, at::kCPU), 1e-5)) << to_string(form);
  // Here a rounding apart moves a number by a step of its few bits: both lose as much, each in its own way.
  const at::Tensor exact = run(LinearForm::f32, at::kCPU);
  for (const LinearForm form : {LinearForm::bf16, LinearForm::int8}) {
    const at::Tensor on_cpu = run(form, at::kCPU);
    EXPECT_LT(uwv::testing::rms(run(form, far_device) - on_cpu), 2 * uwv::testing::rms(on_cpu - exact))
        << to_string(form);
  }
}

TEST_F(FarDeviceParts, LorasAreAddedThere) {
  const std::string folder = fixture_folder("lora");
  int compared = 0;
  for (const std::string& path : uwv::testing::cases_in(folder)) {
    TransformerOptions options;
    const std::string name = std::filesystem::path(path).filename().string().substr(std::string("case_").size());
    options.loras.push_back({LoraFile::open(folder + "/lora_" + name), 0.7});
    const uwv::testing::GoldenCase golden(path);
    const at::Tensor want = golden.run(WanTransformer::open(folder + "/transformer", options));
    options.device = far_device;
    EXPECT_TRUE(near(golden.run(WanTransformer::open(folder + "/transformer", options)).cpu(), want, 1e-5)) << path;
    ++compared;
  }
  EXPECT_GT(compared, 0);
}

TEST_F(FarDeviceParts, TheAutoencoderGivesTheCpusLatentsAndFrames) {
  VaeOptions options;
  const WanVae near_vae = WanVae::open(fixture_folder("vae"), options);
  options.device = far_device;
  const WanVae far_vae = WanVae::open(fixture_folder("vae"), options);
  options.bands = 2;
  const WanVae banded = WanVae::open(fixture_folder("vae"), options);
  const at::Tensor clip = at::rand({1, 3, 5, 32, 24}) * 2 - 1;
  const at::Tensor latents = near_vae.encode(clip, monitor_);
  EXPECT_TRUE(near(far_vae.encode(clip, monitor_), latents, 1e-5));
  EXPECT_TRUE(near(banded.encode(clip, monitor_), latents, 1e-5));
  const at::Tensor frames = near_vae.decode(latents, monitor_);
  EXPECT_TRUE(near(far_vae.decode(latents, monitor_), frames, 1e-5));
  EXPECT_TRUE(near(far_vae.decode(latents.to(far_device), monitor_), frames, 1e-5));
  EXPECT_TRUE(near(banded.decode(latents, monitor_), frames, 1e-5));
}

TEST_F(FarDeviceParts, WhatTheAutoencoderCannotTakeIsStillNamed) {
  VaeOptions options;
  options.device = far_device;
  const WanVae vae = WanVae::open(fixture_folder("vae"), options);
  const at::Tensor huge = at::full({1, vae.config().z_dim, 1, 2, 2}, 1e30);
  EXPECT_THAT(uwv::testing::complaint([&] { vae.decode(huge, monitor_); }), HasSubstr("not finite"));
}

TEST_F(FarDeviceParts, TheTinyDecoderGivesTheCpusFrames) {
  const std::string path = std::string(UWV_TEST_DATA) + "/taehv/taew2_1.safetensors";
  VaeOptions options;
  options.device = far_device;
  const TinyVae tiny = TinyVae::open(path);
  const at::Tensor latents = at::randn({1, tiny.z_dim(), 3, 4, 6});
  const at::Tensor want = tiny.decode(latents, monitor_);
  EXPECT_TRUE(near(TinyVae::open(path, options).decode(latents.to(far_device), monitor_), want, 1e-5));
}

TEST_F(FarDeviceParts, TheTextEncoderGivesTheCpusVectors) {
  const std::string encoder = fixture_folder("text/text_encoder"), tokenizer = fixture_folder("text/tokenizer");
  const std::vector<std::string> prompts{"", "a white rabbit in the snow"};
  const auto want = TextEncoder::open(encoder, tokenizer, LinearForm::f32).encode(prompts, monitor_);
  const auto ours = TextEncoder::open(encoder, tokenizer, LinearForm::f32, far_device).encode(prompts, monitor_);
  for (std::size_t i = 0; i < prompts.size(); ++i) EXPECT_TRUE(near(ours[i], want[i], 1e-5));
}

class FarDevicePipeline : public CompletionTest {};

TEST_F(FarDevicePipeline, FramesAreTheCpus) {
  options_.window_frames = 9;
  options_.window_overlap = 4;
  const Scene scene{.size = {32, 16}, .frames = 13};
  const Answer want = complete(scene);
  options_.device = uwv::testing::far_device_name;
  options_.prompt_cache = cache_.file("prompts of the far device");
  const std::int64_t before = uwv::testing::far_operators();
  const Answer ours = complete(scene);
  EXPECT_GT(uwv::testing::far_operators(), before + 1000);
  EXPECT_EQ(ours.previews, want.previews);
  // A rounding apart may fall on the other side of a whole number.
  EXPECT_LE(difference(ours.frames, want.frames).largest, 1);
  EXPECT_LT(difference(ours.frames, want.frames).mean, 0.01);
}

TEST_F(FarDevicePipeline, EveryOptionThatChangesThePassRunsThere) {
  options_.device = uwv::testing::far_device_name;
  options_.sampler = SamplerKind::unipc;
  options_.step_cache = 0.1;
  options_.cfg_batch = true;
  options_.skip_known = 0;
  options_.vae_fast = std::string(UWV_TEST_DATA) + "/taehv/taew2_1.safetensors";
  EXPECT_TRUE(complete({}).summary.model_was_run);
}

TEST_F(FarDevicePipeline, TheMemoryLimitChoosesNoFormThatOnlyTheCpuIsFastIn) {
  options_.device = uwv::testing::far_device_name;
  const CompletionPlan plan = plan_completion(options_, {48, 32}, 5, 1);
  EXPECT_GT(plan.gflops, 0);
  EXPECT_THAT(plan.choices, Contains(HasSubstr("weights f32")));
}

TEST_F(FarDevicePipeline, ADeviceThatIsNotThereIsRefusedBeforeAnythingIsRead) {
  options_.device = "cuda:99";
  EXPECT_THAT(complaint(options_), HasSubstr("--device cuda:99"));
  EXPECT_THAT(uwv::testing::complaint([&] { check_checkpoint(options_); }), HasSubstr("at hand: cpu"));
}

}  // namespace
}  // namespace uwv::model
