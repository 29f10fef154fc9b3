// SPDX-License-Identifier: Apache-2.0
#include "uwv/model/view_completion.h"

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <optional>

#include "model/diffusion/completion_fixture.h"
#include "model/measured_peak.h"
#include "model/tensor_support.h"
#include "model/transformer/transformer_config.h"
#include "model/vae/tiny_vae_cost.h"
#include "support/matchers.h"
#include "support/temp_folder.h"

namespace uwv {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;

class ViewCompletion : public CompletionTest {};

TEST_F(ViewCompletion, TheSameSeedGivesTheSameBytesAndAnotherDoesNot) {
  const Answer first = complete({});
  EXPECT_TRUE(first.summary.model_was_run);
  EXPECT_EQ(first.summary.passes, 4);
  EXPECT_EQ(first.previews, 2);
  EXPECT_EQ(complete({}).frames, first.frames);
  options_.seed = 7;
  EXPECT_NE(complete({}).frames, first.frames);
}

TEST_F(ViewCompletion, EveryLengthAndSizeComesBackAsItWas) {
  for (const long frames : {1L, 2L, 6L}) complete({.size = {48, 32}, .frames = frames});
  complete({.size = {41, 19}, .frames = 3});
  complete({.size = {16, 16}, .frames = 1, .holes = Holes::all});
}

TEST_F(ViewCompletion, LongClipsAreMadeInWindows) {
  options_.window_frames = 9;
  options_.window_overlap = 4;
  const Answer answer = complete({.size = {16, 16}, .frames = 22});
  EXPECT_GT(answer.summary.windows, 2);
  EXPECT_EQ(answer.summary.passes, 4 * answer.summary.windows);
}

TEST_F(ViewCompletion, WithoutHolesTheRenderingIsTheResult) {
  const Scene scene{.holes = Holes::none};
  const Answer answer = complete(scene);
  EXPECT_FALSE(answer.summary.model_was_run);
  EXPECT_THAT(answer.summary.skipped, Contains(HasSubstr("no frame has a hole")));
  for (long k = 0; k < scene.frames; ++k) EXPECT_EQ(answer.frames[static_cast<std::size_t>(k)], scene.picture(k));
}

TEST_F(ViewCompletion, WhatIsNotNeededIsLeftOutAndSaid) {
  options_.guidance = 1;
  const Answer photo = complete({.photo = true});
  EXPECT_EQ(photo.summary.passes, 2);
  EXPECT_THAT(photo.summary.skipped, Contains(HasSubstr("negative prompt")));
  EXPECT_THAT(photo.summary.skipped, Contains(HasSubstr("reference clip: a photo")));
  options_.colour_correction = false;
  options_.transformer.clear();
  const Answer plain = complete({});
  EXPECT_THAT(plain.summary.skipped, Contains(HasSubstr("no reference branch")));
  EXPECT_THAT(plain.summary.skipped, Contains(HasSubstr("colour correction")));
  EXPECT_THAT(plain.summary.choices, Contains(HasSubstr("unipc")));
}

TEST_F(ViewCompletion, AFirstFrameThatIsUnknownIsNoGuideForColours) {
  EXPECT_THAT(complete({.holes = Holes::all}).summary.skipped, Contains(HasSubstr("too little of the first frame")));
}

TEST_F(ViewCompletion, TheReferenceChangesTheResult) {
  const Answer with = complete({});
  options_.reference = false;
  EXPECT_NE(complete({}).frames, with.frames);
}

TEST_F(ViewCompletion, StreamingGivesTheSameBytes) {
  const Answer resident = complete({});
  options_.stream = StreamChoice::on;
  EXPECT_EQ(complete({}).frames, resident.frames);
}

TEST_F(ViewCompletion, EveryFormOfWeightsStaysNearTheExactAnswer) {
  const Answer exact = complete({});
  for (const WeightsForm form : {WeightsForm::bf16_stored, WeightsForm::int8_stored}) {
    options_.weights = form;
    const Answer answer = complete({});
    double error = 0;
    for (std::size_t k = 0; k < exact.frames.size(); ++k)
      for (std::size_t i = 0; i < exact.frames[k].size().pixels(); ++i)
        error += std::abs(exact.frames[k].data()[i].g - answer.frames[k].data()[i].g);
    EXPECT_LT(error / (5 * 48 * 32), 6);
  }
}

TEST_F(ViewCompletion, AStageBeginsWithoutWhatTheOneBeforeFreed) {
  if (!testing::peaks_can_be_measured()) GTEST_SKIP() << "memory cannot be measured here";
  // Leaves freed memory behind in the midst of denoising, and looks when decoding begins whether it still
  // counts.
  struct Watch : Monitor {
    bool progress(std::string_view stage, long done, long total) override {
      if (stage == "denoising" && 2 * done >= total && !gaps) {
        gaps.emplace(bytes);
        before = testing::resident_memory();
      }
      if (stage == "vae decode" && after == 0) after = testing::resident_memory();
      return true;
    }
    std::size_t bytes = 128 << 20;
    std::optional<testing::FreedBetweenUsed> gaps;
    double before = 0, after = 0;
  } watch;
  CompletedClip out;
  out.write = [](long, const ImageRgb&) {};
  complete_views(options_, Scene().clip(), out, 1, watch);
  ASSERT_GT(watch.before, 0);
  ASSERT_GT(watch.after, 0);
  EXPECT_LT(watch.after, watch.before - 100e6);
}

TEST_F(ViewCompletion, TheTinyDecoderStandsForTheLargeOne) {
  const Answer large = complete({});
  options_.vae_fast = std::string(UWV_TEST_DATA) + "/taehv/taew2_1.safetensors";
  const Answer fast = complete({});
  EXPECT_NE(fast.frames, large.frames);
  // Previews are its pictures too, of the full size.
  EXPECT_EQ(fast.previews, large.previews);
  EXPECT_EQ(large.last_preview.size(), (Size{24, 16}));
  EXPECT_EQ(fast.last_preview.size(), (Size{48, 32}));
  options_.vae_fast = "/no/such/decoder";
  EXPECT_THAT(complaint(options_), HasSubstr("--vae-fast /no/such/decoder"));
}

TEST_F(ViewCompletion, TheAutoencoderWorksInTilesWhereAsked) {
  const Scene scene{.size = {96, 64}, .frames = 5};
  const Answer whole = complete(scene);
  options_.vae_tile = 64;
  EXPECT_NE(complete(scene).frames, whole.frames);
  options_.vae_tile = 96;  // one tile is the whole picture
  EXPECT_EQ(complete(scene).frames, whole.frames);
}

TEST_F(ViewCompletion, AWrongTinyDecoderIsNamedBeforeAnythingIsComputed) {
  const test::TempFolder folder;
  options_.vae_fast = folder.file("other.safetensors");
  uwv::testing::write_safetensors(options_.vae_fast, {{"decoder.0.weight", at::ones({4, 4, 1, 1})}});
  for (const auto& early : {std::function<void()>([&] { check_checkpoint(options_); }), std::function<void()>([&] {
                              plan_completion(options_, {48, 32}, 5, 1);
                            })}) {
    try {
      early();
      ADD_FAILURE() << "nothing was thrown";
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("other.safetensors"));
      EXPECT_THAT(error.what(), HasSubstr("taew2_1"));
    }
  }
}

TEST_F(ViewCompletion, StepCachingLeavesOutPasses) {
  options_.steps = 8;
  options_.step_cache = 5;
  const Answer answer = complete({});
  EXPECT_GT(answer.summary.skipped_passes, 0);
  EXPECT_EQ(answer.summary.passes + answer.summary.skipped_passes, 16);
}

TEST_F(ViewCompletion, KnownTokensFarFromHolesMayBeLeftOut) {
  const Answer all = complete({});
  options_.skip_known = 1000;
  EXPECT_EQ(complete({}).frames, all.frames);
  // Of the two latent frames the first has no hole, of the second the left of three columns of tokens.
  options_.skip_known = 0;
  const Answer few = complete({});
  EXPECT_THAT(few.summary.skipped, Contains("8 of 12 tokens in window 1: skip_known"));
  EXPECT_EQ(few.summary.passes, all.summary.passes);
  EXPECT_NE(few.frames, all.frames);
  EXPECT_EQ(complete({}).frames, few.frames);
}

TEST_F(ViewCompletion, TokensAreLeftOutTogetherWithEveryOtherRung) {
  options_.skip_known = 0;
  const Answer resident = complete({});
  options_.stream = StreamChoice::on;
  EXPECT_EQ(complete({}).frames, resident.frames);
  options_.cfg_batch = true;
  options_.step_cache = 5;
  options_.steps = 8;
  options_.window_frames = 9;
  options_.window_overlap = 4;
  const Answer answer = complete({.size = {48, 32}, .frames = 22});
  EXPECT_GT(answer.summary.skipped_passes, 0);
  EXPECT_THAT(answer.summary.skipped, Contains(HasSubstr("tokens in window 1: skip_known")));
}

TEST_F(ViewCompletion, EncodedPromptsStandForTheEncoder) {
  const test::TempFolder folder;
  options_.prompt_embeds = folder.file("prompts.safetensors");
  const std::int64_t width = model::TransformerConfig::read(options_.transformer).text_dim;
  uwv::testing::write_safetensors(options_.prompt_embeds, {{"prompt_embeds", at::randn({1, 7, width})}});
  EXPECT_THAT(complaint(options_), HasSubstr("negative_prompt_embeds"));
  options_.guidance = 1;
  EXPECT_TRUE(complete({}).summary.model_was_run);
  uwv::testing::write_safetensors(options_.prompt_embeds, {{"prompt_embeds", at::full({1, 7, width}, HUGE_VAL)}});
  EXPECT_THAT(complaint(options_), HasSubstr("no numbers"));
  uwv::testing::write_safetensors(options_.prompt_embeds, {{"prompt_embeds", at::zeros({2, 7, width})}});
  EXPECT_THAT(complaint(options_), HasSubstr("prompt_embeds"));
}

TEST_F(ViewCompletion, TheMemoryLimitPicksTheForm) {
  const auto plan = [&](const std::string& limit) {
    options_.memory_limit = limit;
    return plan_completion(options_, {832, 480}, 5, 1);
  };
  const CompletionPlan large = plan("16G");
  EXPECT_THAT(large.choices, Contains(HasSubstr("weights f32:")));
  EXPECT_GT(large.seconds_per_step, 0);
  EXPECT_THAT(large.report(), HasSubstr("denoising"));
  options_.memory_limit = "10M";
  EXPECT_THAT(complaint(options_), HasSubstr("--memory-limit 10M"));
  const std::uint64_t decoding = large.stages[3].peak_bytes;
  if (decoding * 9 / 10 <= large.stages[2].peak_bytes)
    GTEST_SKIP() << "the autoencoder of these fixtures needs less than their transformer: no limit is its alone";
  const CompletionPlan small = plan(std::to_string(decoding * 9 / 10));
  EXPECT_THAT(small.choices, Contains(HasSubstr("vae_bands")));
  EXPECT_LE(small.stages[3].peak_bytes, decoding * 9 / 10);
}

TEST_F(ViewCompletion, ThePlanReckonsTheTinyDecoderWhereItMakesTheFrames) {
  const auto plan = [&] { return plan_completion(options_, {832, 480}, 21, 1); };
  options_.preview = true;
  const CompletionPlan large = plan();
  options_.vae_fast = std::string(UWV_TEST_DATA) + "/taehv/taew2_1.safetensors";
  const CompletionPlan fast = plan();
  const model::TinyVaeSizes sizes = model::TinyVaeSizes::read(options_.vae_fast);
  const model::ClipSize clip{21, 480, 832};
  EXPECT_EQ(fast.stages[3].peak_bytes,
            static_cast<std::uint64_t>(model::estimated_peak_bytes(sizes, clip, model::VaePrecision::f32)));
  EXPECT_NE(fast.stages[3].peak_bytes, large.stages[3].peak_bytes);
  EXPECT_EQ(fast.stages[0].peak_bytes, large.stages[0].peak_bytes);
  EXPECT_GT(fast.stages[2].peak_bytes, large.stages[2].peak_bytes);
  options_.preview = false;
  EXPECT_EQ(plan().stages[2].peak_bytes, large.stages[2].peak_bytes);
}

TEST_F(ViewCompletion, ThePlanTellsWhatAStreamedPassReads) {
  const auto plan = [&] { return plan_completion(options_, {48, 32}, 5, 1); };
  EXPECT_FALSE(plan().reading);
  options_.stream = StreamChoice::on;
  const CompletionPlan streamed = plan();
  ASSERT_TRUE(streamed.reading);
  EXPECT_GT(streamed.reading->bytes, 1000U);
  EXPECT_GT(streamed.reading->computing, 0);
  EXPECT_TRUE(streamed.reading->first_pass_only);
  EXPECT_THAT(streamed.report(), HasSubstr("each pass reads"));
  EXPECT_THAT(streamed.report(), HasSubstr("only the first pass"));
  CompletionPlan::Reading reading;
  EXPECT_THAT(reading.sentence(), HasSubstr("could not be measured"));
  reading = {.bytes = 3ULL << 30, .bytes_per_second = 1.5e9, .seconds = 2.1, .computing = 4.2};
  EXPECT_EQ(reading.sentence(),
            "each pass reads 3.0 GiB from disk at 1500 MB/s: 2.1 s, while it computes for 4.2 s, and takes the longer");
}

TEST_F(ViewCompletion, MissingPartsAreNamed) {
  const test::TempFolder folder;
  const std::string model = folder.file("model");
  fs::copy(options_.model, model, fs::copy_options::recursive);
  options_.model = model;
  fs::remove_all(model + "/tokenizer");
  EXPECT_THAT(complaint(options_), HasSubstr("tokenizer/"));
  fs::remove_all(model + "/text_encoder");
  EXPECT_THAT(complaint(options_), HasSubstr("--prompt-embeds"));
  fs::remove_all(model + "/vae");
  EXPECT_THAT(complaint(options_), HasSubstr("vae/config.json"));
  fs::remove_all(model + "/transformer");
  options_.transformer.clear();
  EXPECT_THAT(complaint(options_), HasSubstr("--transformer"));
  options_.model = folder.file("nowhere");
  EXPECT_THAT(complaint(options_), HasSubstr("nowhere"));
}

TEST_F(ViewCompletion, LorasThatCannotBeReadAreNamed) {
  options_.lora = {"/no/such/lora.safetensors:0.95"};
  EXPECT_THAT(complaint(options_), HasSubstr("/no/such/lora.safetensors: no such file"));
  options_.lora = {options_.prompt_cache + ":1e9"};
  EXPECT_THAT(complaint(options_), HasSubstr("weight 1000000000"));
}

/// Stops after some reports of one stage.
class Stopper : public Monitor {
 public:
  Stopper(std::string stage, int after) : stage_(std::move(stage)), left_(after) {}
  bool progress(std::string_view stage, long, long) override { return stage != stage_ || --left_ > 0; }

 private:
  std::string stage_;
  int left_;
};

TEST_F(ViewCompletion, StopsWithinAPassOfTheTransformer) {
  Stopper stopper("denoising", 3);
  CompletedClip out;
  out.write = [](long, const ImageRgb&) { ADD_FAILURE() << "a frame of a job that was stopped"; };
  const Scene scene;
  try {
    complete_views(options_, scene.clip(), out, 1, stopper);
    FAIL() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::cancelled);
  }
}

TEST(ModelOptions, BytesAreReadWithUnits) {
  EXPECT_EQ(parse_bytes("16G"), std::uint64_t{16} << 30U);
  EXPECT_EQ(parse_bytes("1.5GiB"), std::uint64_t{3} << 29U);
  EXPECT_EQ(parse_bytes("1000"), 1000U);
  for (const char* text : {"", "G", "-1G", "0", "1X", "1GG", "nan", "1e30"}) EXPECT_FALSE(parse_bytes(text)) << text;
}

TEST(ModelOptions, DefaultsFollowTheOfficialScripts) {
  ModelOptions options;
  EXPECT_EQ(options.sampling().steps, 50);
  EXPECT_EQ(options.guidance_scale(), 6);
  options.lora = {"causvid.safetensors"};
  EXPECT_EQ(options.sampling().steps, 8);
  EXPECT_EQ(options.sampling().kind, model::SamplerKind::euler);
  EXPECT_EQ(options.guidance_scale(), 4);
  options.few_steps = true;
  EXPECT_EQ(options.sampling().steps, 4);
  EXPECT_EQ(options.guidance_scale(), 1);
}

TEST(ModelOptions, ValuesOutOfRangeAreRefusedByName) {
  const auto refuses = [](auto change) {
    ModelOptions options;
    change(options);
    EXPECT_THROW(options.check(), std::invalid_argument);
  };
  refuses([](ModelOptions& o) { o.steps = 0; });
  refuses([](ModelOptions& o) { o.shift = -1; });
  refuses([](ModelOptions& o) { o.guidance = 1000; });
  refuses([](ModelOptions& o) { o.cfg_share = 2; });
  refuses([](ModelOptions& o) { o.seed = -1; });
  refuses([](ModelOptions& o) { o.window_frames = 80; });
  refuses([](ModelOptions& o) { o.window_overlap = 80; });
  refuses([](ModelOptions& o) { o.memory_limit = "much"; });
  refuses([](ModelOptions& o) { o.step_cache = std::nan(""); });
  refuses([](ModelOptions& o) { o.skip_known = -1; });
}

}  // namespace
}  // namespace uwv
