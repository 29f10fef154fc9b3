// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/conditioning.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "model/diffusion/noise.h"
#include "model/tensor_support.h"
#include "support/matchers.h"

namespace uwv::model {
namespace {

using ::testing::ElementsAre;
using uwv::testing::near;

at::Tensor picked(const at::Tensor& mask) {
  const std::int64_t latents = latent_frames(mask.size(2));
  return mask.index_select(2, at::tensor(mask_frames(mask.size(2), latents)));
}

TEST(Conditioning, MaskFramesAreTheReferences) {
  EXPECT_THAT(mask_frames(81, 21),
              ElementsAre(1, 5, 9, 13, 17, 21, 25, 28, 32, 36, 40, 44, 48, 52, 55, 59, 63, 67, 71, 75, 79));
  EXPECT_THAT(mask_frames(49, 13), ElementsAre(1, 5, 9, 13, 16, 20, 24, 28, 32, 35, 39, 43, 47));
  EXPECT_THAT(mask_frames(17, 5), ElementsAre(1, 5, 8, 11, 15));
  EXPECT_THAT(mask_frames(9, 3), ElementsAre(1, 4, 7));
  EXPECT_THAT(mask_frames(5, 2), ElementsAre(1, 3));
  EXPECT_THAT(mask_frames(1, 1), ElementsAre(0));
}

TEST(Conditioning, ClipsAreMadeLongerToWholeLatents) {
  for (std::int64_t frames = 1; frames < 200; ++frames) {
    const std::int64_t whole = whole_frames(frames);
    EXPECT_EQ(whole % 4, 1);
    EXPECT_GE(whole, frames);
    EXPECT_LT(whole, frames + 4);
    EXPECT_EQ(frames_of(latent_frames(whole)), whole);
  }
}

TEST(Conditioning, EachPixelUnderALatentHasItsChannelRowByRow) {
  const at::Tensor mask = at::arange(16 * 24, at::kFloat).reshape({1, 1, 1, 16, 24});
  const at::Tensor channels = mask_channels(mask);
  ASSERT_EQ(channels.sizes(), (std::vector<std::int64_t>{1, 64, 1, 2, 3}));
  for (std::int64_t y = 0; y < 16; ++y)
    for (std::int64_t x = 0; x < 24; ++x)
      EXPECT_EQ(channels[0][8 * (y % 8) + x % 8][0][y / 8][x / 8].item<float>(), mask[0][0][0][y][x].item<float>());
  EXPECT_THROW(mask_channels(at::zeros({1, 1, 1, 12, 16})), std::invalid_argument);
}

TEST(Conditioning, PartsAreGreyWhereTheOtherIs) {
  const at::Tensor video = at::full({1, 3, 1, 1, 4}, -1.0);
  const at::Tensor mask = at::tensor({0.0F, 0.5F, 0.51F, 1.0F}).view({1, 1, 1, 1, 4});
  EXPECT_TRUE(near(known_part(video, mask)[0][0][0][0], at::tensor({-1.0F, -1.0F, 0.0F, 0.0F}), 0));
  EXPECT_TRUE(near(hole_part(video, mask)[0][0][0][0], at::tensor({0.0F, 0.0F, -1.0F, -1.0F}), 0));
}

TEST(ConditioningParity, MaskChannelsEqualThePipelines) {
  int seen = 0;
  for (const auto& entry : std::filesystem::directory_iterator(uwv::testing::fixture_folder("pipeline"))) {
    if (!std::filesystem::exists(entry.path() / "case.safetensors")) continue;
    const WeightFiles file = WeightFiles::open((entry.path() / "case.safetensors").string());
    const at::Tensor mask = file.has("in.mask")
                                ? file.load("in.mask", at::kFloat)
                                : file.load("in.mask_u8", at::kFloat).div(255).unsqueeze(0).unsqueeze(0);
    const at::Tensor channels = mask_channels(picked(mask));
    at::Tensor golden = file.load("conditioning_latents", at::kFloat).narrow(1, 32, 64);
    // A reference image stands before the clip; we have none.
    golden = golden.narrow(2, golden.size(2) - channels.size(2), channels.size(2));
    EXPECT_TRUE(near(channels, golden, 0)) << entry.path();
    ++seen;
  }
  EXPECT_GT(seen, 2);
}

TEST(NoiseParity, EqualsTorchInPythonAndDependsOnTheSeedAlone) {
  // torch.randn(1, 16, 3, 4, 6, generator=torch.Generator().manual_seed(42)), torch 2.15.0
  const at::Tensor noise = seeded_noise({1, 16, 3, 4, 6}, 42).flatten();
  EXPECT_TRUE(near(noise.narrow(0, 0, 3), at::tensor({1.9269153F, 1.4872841F, 0.9007172F}), 1e-6));
  EXPECT_TRUE(near(noise.narrow(0, 16 * 72 - 3, 3), at::tensor({-0.6061143F, 0.6449756F, -0.24771355F}), 1e-6));
  EXPECT_TRUE(at::equal(seeded_noise({1, 16, 3, 4, 6}, 42).flatten(), noise));
  EXPECT_FALSE(at::equal(seeded_noise({1, 16, 3, 4, 6}, 43).flatten(), noise));
}

}  // namespace
}  // namespace uwv::model
