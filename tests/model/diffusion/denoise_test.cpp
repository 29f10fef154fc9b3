// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/denoise.h"

#include <gmock/gmock.h>

#include "model/diffusion/noise.h"
#include "model/diffusion/step_cache.h"
#include "model/tensor_support.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

using uwv::testing::near;

/// A network that knows two clips: where the text and where the negative text leads. Counts its passes.
class KnowingModel : public WindowModel {
 public:
  KnowingModel(at::Tensor positive, at::Tensor negative, int* passes)
      : positive_(std::move(positive)), negative_(std::move(negative)), passes_(passes) {}
  at::Tensor velocity(const at::Tensor& latents, double timestep, Branch branch) override {
    ++*passes_;
    const auto towards = [&](const at::Tensor& clip) { return (latents - clip) / (timestep / 1000); };
    if (branch == Branch::positive) return towards(positive_);
    if (branch == Branch::negative) return towards(negative_);
    return at::cat({towards(positive_), towards(negative_)});
  }

 private:
  at::Tensor positive_, negative_;
  int* passes_;
};

const std::vector<std::int64_t> shape{1, 16, 6, 2, 3};

struct Answer {
  at::Tensor latents;
  int passes = 0;
};

Answer run(const at::Tensor& positive, const at::Tensor& negative, const DenoiseOptions& options,
           const WindowOptions& window_options = {}) {
  Answer answer;
  std::vector<DenoiseWindow> windows;
  for (const Window& place : plan_windows(positive.size(2), window_options)) {
    const auto part = [&](const at::Tensor& clip) { return clip.narrow(2, place.first, place.count); };
    windows.push_back({place, std::make_unique<KnowingModel>(part(positive), part(negative), &answer.passes), {}});
  }
  answer.latents = denoise(seeded_noise(positive.sizes(), 1), windows, {}, options);
  return answer;
}

TEST(Denoise, GuidanceGoesBeyondThePositiveClip) {
  const at::Tensor positive = seeded_noise(shape, 2), negative = seeded_noise(shape, 3);
  const at::Tensor wanted = negative + 3 * (positive - negative);
  const Answer two = run(positive, negative, {{SamplerKind::euler, 5, 5}, 3});
  EXPECT_TRUE(near(two.latents, wanted, 1e-4));
  EXPECT_EQ(two.passes, 10);
  const Answer batch = run(positive, negative, {{SamplerKind::euler, 5, 5}, 3, 1, true});
  EXPECT_TRUE(near(batch.latents, two.latents, 1e-5));
  EXPECT_EQ(batch.passes, 5);
}

TEST(Denoise, TheNegativeBranchRunsOnlyWhereItCounts) {
  const at::Tensor positive = seeded_noise(shape, 2), negative = seeded_noise(shape, 3);
  EXPECT_EQ(run(positive, negative, {{SamplerKind::euler, 8, 5}, 1}).passes, 8);
  EXPECT_EQ(run(positive, negative, {{SamplerKind::euler, 8, 5}, 4, 0.5}).passes, 12);
  EXPECT_EQ(run(positive, negative, {{SamplerKind::euler, 8, 5}, 4, 0}).passes, 8);
  EXPECT_TRUE(near(run(positive, negative, {{SamplerKind::euler, 8, 5}, 1}).latents, positive, 1e-4));
}

TEST(Denoise, WindowsThatAgreeGiveTheClipOfOneWindow) {
  const std::vector<std::int64_t> long_shape{1, 16, 23, 2, 3};
  const at::Tensor clip = seeded_noise(long_shape, 2);
  const Answer whole = run(clip, clip, {{SamplerKind::unipc, 6, 5}, 1}, {93, 4});
  const Answer cut = run(clip, clip, {{SamplerKind::unipc, 6, 5}, 1}, {33, 8});
  EXPECT_EQ(whole.passes, 6);
  EXPECT_GT(cut.passes, 12);
  EXPECT_TRUE(near(cut.latents, whole.latents, 1e-4));
}

TEST(Denoise, WindowsThatDisagreeMeetWithoutASeam) {
  // Each window wants its own number; the answer must go from one to the next in steps no larger than a ramp's.
  const std::int64_t latents = 40;
  std::vector<DenoiseWindow> windows;
  int passes = 0;
  float wish = 0;
  const WindowOptions options{57, 20};
  for (const Window& place : plan_windows(latents, options)) {
    const at::Tensor clip = at::full({1, 16, place.count, 2, 2}, wish);
    windows.push_back({place, std::make_unique<KnowingModel>(clip, clip, &passes), {}});
    wish += 1;
  }
  ASSERT_GT(windows.size(), 2U);
  const at::Tensor answer =
      denoise(seeded_noise({1, 16, latents, 2, 2}, 1), windows, {}, {{SamplerKind::euler, 10, 5}, 1});
  const at::Tensor steps = answer.diff(1, 2).abs();
  EXPECT_LT(steps.max().item<double>(), 1.0 / (options.overlap / 4) + 0.05);
  EXPECT_NEAR(answer[0][0][0][0][0].item<double>(), 0, 1e-3);
  EXPECT_NEAR(answer[0][0][latents - 1][0][0].item<double>(), wish - 1, 1e-3);
}

TEST(Denoise, AWindowWithoutModelEndsAtWhatIsKnown) {
  const at::Tensor known = seeded_noise(shape, 5);
  for (const SamplerKind kind : {SamplerKind::euler, SamplerKind::unipc, SamplerKind::dpmpp}) {
    std::vector<DenoiseWindow> windows;
    windows.push_back({plan_windows(6, {})[0], nullptr, {}});
    EXPECT_TRUE(near(denoise(seeded_noise(shape, 1), windows, known, {{kind, 8, 5}, 4}), known, 1e-4));
  }
}

TEST(Denoise, LatentsThatAreLeftOutEndAtWhatIsKnown) {
  const at::Tensor clip = seeded_noise(shape, 2), known = seeded_noise(shape, 5);
  at::Tensor left_out = at::zeros({1, 1, 6, 2, 3}, at::kBool);
  left_out.select(4, 0).fill_(true);
  left_out.select(2, 1).fill_(true);
  for (const bool batch : {false, true})
    for (const SamplerKind kind : {SamplerKind::euler, SamplerKind::unipc, SamplerKind::dpmpp}) {
      int passes = 0;
      std::vector<DenoiseWindow> windows;
      windows.push_back({plan_windows(6, {})[0], std::make_unique<KnowingModel>(clip, clip, &passes), left_out});
      const at::Tensor answer = denoise(seeded_noise(shape, 1), windows, known, {{kind, 8, 5}, 4, 1, batch});
      const at::Tensor whole = run(clip, clip, {{kind, 8, 5}, 4, 1, batch}).latents;
      EXPECT_TRUE(near(answer, at::where(left_out, known, whole), 1e-4)) << to_string(kind);
    }
}

TEST(Denoise, WhereTheNetworkAgreesWithWhatIsKnownLeavingOutShowsNoBorder) {
  const at::Tensor clip = seeded_noise(shape, 2);
  at::Tensor left_out = at::zeros({1, 1, 6, 2, 3}, at::kBool);
  left_out.select(4, 0).fill_(true);
  int passes = 0;
  std::vector<DenoiseWindow> windows;
  windows.push_back({plan_windows(6, {})[0], std::make_unique<KnowingModel>(clip, clip, &passes), left_out});
  // This sampler tells the network sigma as it is; the others round the timestep.
  const DenoiseOptions options{{SamplerKind::euler, 8, 5}, 4};
  EXPECT_TRUE(near(denoise(seeded_noise(shape, 1), windows, clip, options), run(clip, clip, options).latents, 1e-4));
}

TEST(Denoise, EveryStepIsShownAndMayStop) {
  const at::Tensor clip = seeded_noise(shape, 2);
  int passes = 0;
  std::vector<DenoiseWindow> windows;
  windows.push_back({plan_windows(6, {})[0], std::make_unique<KnowingModel>(clip, clip, &passes), {}});
  const auto watch = [&](const DenoiseStep& step) {
    EXPECT_EQ(step.total, 8);
    EXPECT_TRUE(near(step.noiseless, clip, 1e-4));
    if (step.done == 3) fail(ErrorCode::cancelled, "enough");
  };
  EXPECT_THROW(denoise(seeded_noise(shape, 1), windows, {}, {{SamplerKind::euler, 8, 5}, 1}, watch), Error);
  EXPECT_EQ(passes, 3);
}

TEST(Denoise, OptionsOutOfRangeAreRefused) {
  DenoiseOptions options;
  options.guidance = std::nan("");
  EXPECT_THROW(options.check(), std::invalid_argument);
  options.guidance = 4;
  options.cfg_share = 1.5;
  EXPECT_THROW(options.check(), std::invalid_argument);
}

TEST(StepCache, LeavesOutStepsUntilChangesAddUpToTheThreshold) {
  StepCache cache(0.25);
  std::vector<bool> skipped;
  double value = 1;
  for (int i = 0; i < 7; ++i) {
    skipped.push_back(cache.may_skip(at::full({1, 4, 8}, value)));
    value *= 1.1;
  }
  EXPECT_THAT(skipped, ::testing::ElementsAre(false, true, true, false, true, true, false));
  EXPECT_EQ(cache.skipped(), 4);
}

TEST(StepCache, ThresholdZeroAndInputsOfZeroNeverLeaveOut) {
  StepCache off(0), zeros(0.5);
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(off.may_skip(at::ones({1, 4, 8})));
    EXPECT_FALSE(zeros.may_skip(at::zeros({1, 4, 8})));
  }
}

}  // namespace
}  // namespace uwv::model
