// SPDX-License-Identifier: Apache-2.0
#include "model/vae/wan_vae.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "model/layers/torch_scope.h"
#include "model/tensor_support.h"
#include "model/vae/vae_shapes.h"
#include "support/matchers.h"
#include "support/temp_folder.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

using uwv::testing::fixture_folder;
using uwv::testing::near;

constexpr double latents_tolerance = 2e-4;
constexpr double decoded_tolerance = 1e-4;

std::vector<std::string> cases() {
  std::vector<std::string> found;
  for (const auto& entry : std::filesystem::directory_iterator(fixture_folder("vae")))
    if (entry.path().filename().string().starts_with("case_")) found.push_back(entry.path().string());
  return found;
}

/// What the parts gave, as clips (1, C, T, H, W).
class Probed {
 public:
  VaeProbe probe() {
    return
        [this](std::string_view part, const at::Tensor& frame) { frames_[std::string(part)].push_back(frame.clone()); };
  }
  at::Tensor clip(const std::string& part) const {
    return at::stack(frames_.at(part)).permute({3, 0, 1, 2}).unsqueeze(0);
  }

 private:
  std::map<std::string, std::vector<at::Tensor>> frames_;
};

/// Goldens that only some cases have.
void expect_near_if_there(const WeightFiles& golden, const std::string& name, const at::Tensor& ours,
                          double tolerance) {
  if (!golden.has(name)) return;
  EXPECT_TRUE(near(ours, golden.view(name), tolerance)) << name;
}

TEST(WanVaeParity, EveryCaseEncodesPartByPart) {
  const TorchScope scope(1);
  const WanVae vae = WanVae::open(fixture_folder("vae"));
  Monitor monitor;
  ASSERT_FALSE(cases().empty());
  for (const std::string& path : cases()) {
    SCOPED_TRACE(path);
    const WeightFiles golden = WeightFiles::open(path);
    Probed probed;
    const at::Tensor latents = vae.encode(golden.view("video"), monitor, probed.probe());
    expect_near_if_there(golden, "enc_conv_in", probed.clip("conv_in"), latents_tolerance);
    expect_near_if_there(golden, "enc_mid_block", probed.clip("mid_block"), latents_tolerance);
    EXPECT_TRUE(near(latents, golden.view("latents_normalised"), latents_tolerance));
  }
}

/// What the golden frames were decoded from, in units of the latents' spread.
at::Tensor normalised_input(const WeightFiles& golden, const VaeConfig& config) {
  const auto by_channel = [](const std::vector<float>& values) { return at::tensor(values).view({1, -1, 1, 1, 1}); };
  return (golden.view("decode_input") - by_channel(config.latents_mean)) / by_channel(config.latents_std);
}

TEST(WanVaeParity, EveryCaseDecodesPartByPart) {
  const TorchScope scope(1);
  const WanVae vae = WanVae::open(fixture_folder("vae"));
  Monitor monitor;
  for (const std::string& path : cases()) {
    SCOPED_TRACE(path);
    const WeightFiles golden = WeightFiles::open(path);
    Probed probed;
    const at::Tensor decoded = vae.decode(normalised_input(golden, vae.config()), monitor, probed.probe());
    expect_near_if_there(golden, "dec_conv_in", probed.clip("conv_in"), decoded_tolerance);
    expect_near_if_there(golden, "dec_mid_block", probed.clip("mid_block"), decoded_tolerance);
    expect_near_if_there(golden, "decoded_preclamp", probed.clip("out"), decoded_tolerance);
    EXPECT_TRUE(near(decoded, golden.view("decoded"), decoded_tolerance));
  }
}

TEST(WanVaeParity, BandsChangeNothing) {
  const TorchScope scope(1);
  Monitor monitor;
  for (const int bands : {2, 3, 64}) {
    VaeOptions options;
    options.bands = bands;
    const WanVae vae = WanVae::open(fixture_folder("vae"), options);
    for (const std::string& path : cases()) {
      SCOPED_TRACE(path + " in bands: " + std::to_string(bands));
      const WeightFiles golden = WeightFiles::open(path);
      const at::Tensor latents = vae.encode(golden.view("video"), monitor);
      EXPECT_TRUE(near(latents, golden.view("latents_normalised"), latents_tolerance));
      EXPECT_TRUE(
          near(vae.decode(normalised_input(golden, vae.config()), monitor), golden.view("decoded"), decoded_tolerance));
    }
  }
}

/// A network wide enough for Winograd's convolutions, with random weights.
void write_random_vae(const std::string& folder, std::int64_t base_dim) {
  VaeConfig config = VaeConfig::read(fixture_folder("vae") + "/config.json");
  config.base_dim = config.decoder_base_dim = base_dim;
  nlohmann::json file = nlohmann::json::parse(std::ifstream(fixture_folder("vae") + "/config.json"));
  file["base_dim"] = base_dim;
  uwv::testing::write_text(folder + "/config.json", file.dump());
  std::map<std::string, at::Tensor> tensors;
  for (const auto& [name, shape] : vae_shapes(config)) {
    std::int64_t read = 1;
    for (std::size_t i = 1; i < shape.size(); ++i) read *= shape[i];
    tensors[name] = name.ends_with("gamma")
                        ? at::ones(shape)
                        : at::randn(shape) / std::sqrt(static_cast<double>(shape.size() < 2 ? 100 : read));
  }
  uwv::testing::write_safetensors(folder + "/diffusion_pytorch_model.safetensors", tensors);
}

TEST(WanVae, WinogradsConvolutionsGiveTheFramesOfPlainSums) {
  const TorchScope scope(1);
  at::manual_seed(4);
  const test::TempFolder folder;
  write_random_vae(folder.path().string(), 16);
  const at::Tensor video = at::rand({1, 3, 5, 48, 72}) * 2 - 1;
  Monitor monitor;
  VaeOptions options;
  const WanVae fast = WanVae::open(folder.path().string(), options);
  options.winograd = false;
  const WanVae plain = WanVae::open(folder.path().string(), options);
  const at::Tensor latents = plain.encode(video, monitor), frames = plain.decode(latents, monitor);
  const at::Tensor fast_latents = fast.encode(video, monitor), fast_frames = fast.decode(latents, monitor);
  EXPECT_TRUE(near(fast_latents, latents, latents_tolerance));
  EXPECT_TRUE(near(fast_frames, frames, decoded_tolerance));
  EXPECT_FALSE(at::equal(fast_latents, latents));
  EXPECT_FALSE(at::equal(fast_frames, frames));
}

}  // namespace
}  // namespace uwv::model
