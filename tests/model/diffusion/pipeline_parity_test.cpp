// SPDX-License-Identifier: Apache-2.0
// The whole way from frames to frames against the official pipeline and diffusers' own, step by step.
#include <gmock/gmock.h>

#include <filesystem>

#include "model/diffusion/clip_conditions.h"
#include "model/diffusion/decoded_frames.h"
#include "model/diffusion/window_network.h"
#include "model/layers/torch_scope.h"
#include "model/sampling/scheduler_config.h"
#include "model/tensor_support.h"
#include "support/matchers.h"

namespace uwv::model {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using uwv::testing::near;

/// A case of the fixtures, as our pipeline sees it.
struct Case {
  std::string name, transformer, vae, scheduler;
  json call;
  WeightFiles file;

  at::Tensor get(const std::string& tensor) const { return file.load(tensor, at::kFloat); }
  bool has_reference_image() const { return call.value("reference_image", false); }
  double guidance() const { return call.at("guidance_scale"); }

  at::Tensor video() const {
    if (file.has("in.video")) return get("in.video");
    return get("in.video_u8").permute({3, 0, 1, 2}).div(127.5).sub(1).unsqueeze(0).contiguous();
  }
  at::Tensor mask() const {
    return file.has("in.mask") ? get("in.mask") : get("in.mask_u8").div(255).unsqueeze(0).unsqueeze(0);
  }

  ClipTensors clip() const {
    ClipTensors clip;
    clip.frames = video().size(2);
    clip.height = video().size(3);
    clip.width = video().size(4);
    const auto from = [](const at::Tensor& whole) {
      return [whole](std::int64_t first, std::int64_t count) { return whole.narrow(2, first, count); };
    };
    clip.video = from(video());
    clip.mask = from(mask());
    if (!file.has("in.ref_video")) return clip;
    clip.source = from(get("in.ref_video"));
    clip.source_frames = get("in.ref_video").size(2);
    return clip;
  }

  DenoiseOptions denoise_options() const {
    DenoiseOptions options{read_scheduler_config(scheduler + "/scheduler_config.json"), guidance()};
    options.sampler.steps = call.at("num_inference_steps");
    return options;
  }

  WindowInputs inputs() const {
    WindowInputs inputs;
    inputs.control = get("conditioning_latents");
    if (file.has("ref_latents")) inputs.reference = get("ref_latents");
    inputs.positive = get("prompt_embeds");
    if (file.has("negative_prompt_embeds")) inputs.negative = get("negative_prompt_embeds");
    inputs.control_scale = get("conditioning_scale");
    return inputs;
  }
};

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const fs::directory_entry& entry : fs::directory_iterator(uwv::testing::fixture_folder("pipeline"))) {
    if (!fs::exists(entry.path() / "case.safetensors")) continue;
    std::ifstream file(entry.path() / "call.json");
    const json call = json::parse(file);
    const auto path = [&](const char* key) { return (entry.path() / call.at(key).get<std::string>()).string(); };
    const std::string repo = path(call.contains("repo") ? "repo" : "rest");
    all.push_back({entry.path().filename().string(),
                   call.contains("repo") ? repo + "/transformer" : path("transformer"), repo + "/vae",
                   path("scheduler"), call, WeightFiles::open((entry.path() / "case.safetensors").string())});
  }
  return all;
}

class PipelineParity : public ::testing::Test {
 protected:
  TorchScope scope_{1};
  Monitor monitor_;
};

TEST_F(PipelineParity, Conditioning) {
  int seen = 0;
  for (const Case& one : cases()) {
    // An image of reference in front of the clip is VACE's own; the official code never gives one, nor do we.
    if (one.has_reference_image()) continue;
    const WanVae vae = WanVae::open(one.vae);
    const ClipConditions conditions = encode_conditions(vae, one.clip(), monitor_);
    const at::Tensor golden = one.get("conditioning_latents");
    EXPECT_TRUE(near(conditions.control.narrow(1, 0, 32), golden.narrow(1, 0, 32), 2e-4)) << one.name;
    EXPECT_TRUE(near(conditions.control.narrow(1, 32, 64), golden.narrow(1, 32, 64), 0)) << one.name;
    if (one.file.has("ref_latents")) {
      EXPECT_TRUE(near(encode_reference(vae, one.clip(), 0, monitor_), one.get("ref_latents"), 2e-4)) << one.name;
    }
    ++seen;
  }
  EXPECT_GT(seen, 3);
}

TEST_F(PipelineParity, VelocitiesAndLatentsOfEveryStep) {
  for (const Case& one : cases()) {
    for (const bool batch : {false, true}) {
      DenoiseOptions options = one.denoise_options();
      options.cfg_batch = batch;
      const WanTransformer network = WanTransformer::open(one.transformer, {});
      PassCount count;
      std::vector<DenoiseWindow> windows;
      const at::Tensor noise = one.get("in.initial_latents");
      windows.push_back({plan_windows(noise.size(2), {}).front(),
                         std::make_unique<WindowNetwork>(network, one.inputs(), 0, count),
                         {}});
      const at::Tensor golden = one.get("latents_steps");
      denoise(noise, windows, {}, options, [&](const DenoiseStep& step) {
        EXPECT_TRUE(near(step.latents, golden[step.done - 1], 5e-4)) << one.name << ", step " << step.done;
      });
      EXPECT_EQ(count.passes, options.sampler.steps * (one.guidance() > 1 ? 2 : 1)) << one.name;
    }
  }
}

TEST_F(PipelineParity, FramesFromTheReferencesLatents) {
  for (const Case& one : cases()) {
    const at::Tensor steps = one.get("latents_steps");
    at::Tensor latents = steps[steps.size(0) - 1];
    if (one.has_reference_image()) latents = latents.narrow(2, 1, latents.size(2) - 1);
    const at::Tensor frames = WanVae::open(one.vae).decode(latents, monitor_).div(2).add(0.5).clamp(0, 1);
    EXPECT_TRUE(near(frames.permute({0, 2, 3, 4, 1}), one.get("frames"), 5e-4)) << one.name;
  }
}

TEST_F(PipelineParity, FramesFromFrames) {
  for (const Case& one : cases()) {
    if (one.has_reference_image()) continue;
    const WanVae vae = WanVae::open(one.vae);
    const ClipTensors clip = one.clip();
    WindowInputs inputs = one.inputs();
    inputs.control = encode_conditions(vae, clip, monitor_).control;
    if (clip.source) inputs.reference = encode_reference(vae, clip, 0, monitor_);
    const WanTransformer network = WanTransformer::open(one.transformer, {});
    PassCount count;
    std::vector<DenoiseWindow> windows;
    const at::Tensor noise = one.get("in.initial_latents");
    windows.push_back(
        {plan_windows(noise.size(2), {}).front(), std::make_unique<WindowNetwork>(network, inputs, 0, count), {}});
    const at::Tensor latents = denoise(noise, windows, {}, one.denoise_options());
    const at::Tensor frames = vae.decode(latents, monitor_).div(2).add(0.5).clamp(0, 1);
    EXPECT_TRUE(near(frames.permute({0, 2, 3, 4, 1}), one.get("frames"), 5e-4)) << one.name;
  }
}

}  // namespace
}  // namespace uwv::model
