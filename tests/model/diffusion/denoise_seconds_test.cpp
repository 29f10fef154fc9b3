// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/denoise_seconds.h"

#include <gtest/gtest.h>

namespace uwv::model {
namespace {

DenoiseOptions ten_guided_steps() {
  DenoiseOptions options;
  options.sampler.steps = 10;
  return options;
}

TEST(DenoiseSeconds, GuidanceTakesAPassMoreWhereItIsOn) {
  DenoiseOptions options = ten_guided_steps();
  EXPECT_DOUBLE_EQ(denoise_seconds(options, 1, {.computing = 3}).a_step, 6);
  EXPECT_DOUBLE_EQ(denoise_seconds(options, 4, {.computing = 3}).all, 240);
  options.cfg_share = 0.5;
  EXPECT_DOUBLE_EQ(denoise_seconds(options, 1, {.computing = 3}).all, 5 * 6 + 5 * 3);
  options.guidance = 1;
  EXPECT_DOUBLE_EQ(denoise_seconds(options, 1, {.computing = 3}).a_step, 3);
}

TEST(DenoiseSeconds, WeightsAreRoundedOnceForBothPromptsOfABatch) {
  DenoiseOptions options = ten_guided_steps();
  EXPECT_DOUBLE_EQ(denoise_seconds(options, 1, {.computing = 3, .rounding = 2}).a_step, 10);
  options.cfg_batch = true;
  EXPECT_DOUBLE_EQ(denoise_seconds(options, 1, {.computing = 3, .rounding = 2}).a_step, 8);
}

TEST(DenoiseSeconds, APassTakesTheLongerOfReadingAndComputing) {
  DenoiseOptions options = ten_guided_steps();
  PassSeconds pass{.computing = 3, .reading = 2, .first_reading = 2};
  EXPECT_DOUBLE_EQ(denoise_seconds(options, 2, pass).all, 2 * 10 * 2 * 3);
  pass.reading = pass.first_reading = 5;
  EXPECT_DOUBLE_EQ(denoise_seconds(options, 2, pass).all, 2 * 10 * 2 * 5);
  EXPECT_DOUBLE_EQ(denoise_seconds(options, 2, pass).a_step, 20);
  // One pass reads for two prompts.
  options.cfg_batch = true;
  EXPECT_DOUBLE_EQ(denoise_seconds(options, 1, pass).a_step, 6);
}

TEST(DenoiseSeconds, WhatStaysInMemoryIsReadOnce) {
  const DenoiseOptions options = ten_guided_steps();
  PassSeconds pass{.computing = 3, .reading = 5, .first_reading = 5, .stays = true};
  EXPECT_DOUBLE_EQ(denoise_seconds(options, 1, pass).all, 19 * 3 + 5);
  EXPECT_DOUBLE_EQ(denoise_seconds(options, 1, pass).a_step, 6);
  pass.first_reading = 1;  // most of it is there already
  EXPECT_DOUBLE_EQ(denoise_seconds(options, 1, pass).all, 20 * 3);
}

}  // namespace
}  // namespace uwv::model
