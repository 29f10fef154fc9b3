// SPDX-License-Identifier: Apache-2.0
#include "model/transformer/transformer_cost.h"

#include <gtest/gtest.h>

namespace uwv::model {
namespace {

TransformerLoad small_clip() {
  TransformerLoad load;
  load.tokens = 1950;
  return load;
}

TEST(TransformerCost, AStepIsTwoFlopsAWeightAndTokenPlusAttention) {
  const TransformerConfig config = TransformerConfig::wan_1_3b();
  // Of each token: all weights in blocks but those of the text's keys; 45 blocks' attention to 1,950 tokens and 512
  // words.
  const double d = 1536, weights = 45 * (6 * d * d + 2 * d * 8960) + 16 * d * d, attention = 45 * 4 * d * (1950 + 512);
  EXPECT_NEAR(estimated_flops(config, small_clip()) / (1950 * (2 * weights + attention)), 1, 0.001);
}

TEST(TransformerCost, AttentionIsTheShareThatGrowsWithTheSquare) {
  const TransformerConfig config = TransformerConfig::wan_14b();
  TransformerLoad load = small_clip(), twice = load;
  twice.tokens = 2 * load.tokens;
  const auto rest = [&](const TransformerLoad& l) {
    return estimated_flops(config, l) - estimated_attention_flops(config, l);
  };
  EXPECT_NEAR(rest(twice) / rest(load), 2, 0.001);
  load.text_tokens = twice.text_tokens = 1;
  EXPECT_NEAR(estimated_attention_flops(config, twice) / estimated_attention_flops(config, load), 4, 0.01);
}

TEST(TransformerCost, ReferenceTokensCostOnlyWhereThereIsABranch) {
  TransformerLoad load = small_clip(), with = load;
  with.reference_tokens = 390;
  EXPECT_EQ(estimated_flops(TransformerConfig::wan_1_3b(), with), estimated_flops(TransformerConfig::wan_1_3b(), load));
  EXPECT_GT(estimated_flops(TransformerConfig::wan_14b(), with), estimated_flops(TransformerConfig::wan_14b(), load));
}

TEST(TransformerCost, WeightsTakeWhatTheirFormTakes) {
  const TransformerConfig config = TransformerConfig::wan_14b();
  TransformerLoad load = small_clip();
  const double all = static_cast<double>(config.parameters());
  EXPECT_NEAR(estimated_weight_bytes(config, load) / (2 * all), 1, 1e-6);
  load.stored_bytes = 4;
  EXPECT_NEAR(estimated_weight_bytes(config, load) / (4 * all), 1, 1e-6);
  load.form = LinearForm::int8;
  EXPECT_LT(estimated_weight_bytes(config, load), 1.15 * all);
  load.streamed = true;
  EXPECT_LT(estimated_weight_bytes(config, load), 0.2 * all);
  EXPECT_GT(estimated_read_bytes(config, load), 3.8 * all);
}

TEST(TransformerCost, RoundingTheLastBlockMayTakeMoreThanAStep) {
  const TransformerConfig config = TransformerConfig::wan_14b();
  TransformerLoad load;
  load.tokens = load.text_tokens = 1;
  load.form = LinearForm::int8;
  const auto peak = [&](int stored_bytes) {
    load.stored_bytes = stored_bytes;
    return estimated_peak_bytes(config, load);
  };
  // A block of 0.36e9 weights and the two layers beside it as the file holds them.
  const double d = 5120, block = 8 * d * d + 2 * d * 13824 + 6 * d * d;
  EXPECT_NEAR((peak(4) - peak(2)) / (2 * block), 1, 0.1);
}

TEST(TransformerCost, MemoryGrowsWithTokensAndShrinksWithEveryRung) {
  const TransformerConfig config = TransformerConfig::wan_1_3b();
  TransformerLoad load = small_clip();
  load.stored_bytes = 4;
  double last = estimated_peak_bytes(config, load);
  const auto falls = [&](const char* rung) {
    const double now = estimated_peak_bytes(config, load);
    EXPECT_LT(now, last) << rung;
    last = now;
  };
  load.form = LinearForm::bf16_stored;
  falls("bf16_stored");
  load.form = LinearForm::bf16;
  falls("bf16");
  load.form = LinearForm::int8;
  falls("int8");
  load.streamed = true;
  falls("streamed");
  load.keep_keys = false;
  falls("without kept keys");
  load.tokens = 32760;
  EXPECT_GT(estimated_peak_bytes(config, load), last);
  last = estimated_peak_bytes(config, load);
  load.ffn_rows = 2048;
  load.form = LinearForm::f32;
  const double narrow = estimated_peak_bytes(config, load);
  load.ffn_rows = 1 << 20;
  EXPECT_LT(narrow, estimated_peak_bytes(config, load));
}

TEST(TransformerCost, LoadsThatCannotBeAreRefused) {
  TransformerLoad load = small_clip();
  load.tokens = 0;
  EXPECT_THROW(estimated_flops(TransformerConfig::wan_14b(), load), std::invalid_argument);
  load = small_clip();
  load.stored_bytes = 3;
  EXPECT_THROW(estimated_peak_bytes(TransformerConfig::wan_14b(), load), std::invalid_argument);
}

}  // namespace
}  // namespace uwv::model
