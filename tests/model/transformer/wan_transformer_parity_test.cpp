// SPDX-License-Identifier: Apache-2.0
// Every intermediate of the official networks, against what diffusers and the official code computed.
#include <gtest/gtest.h>

#include <set>

#include "model/layers/torch_scope.h"
#include "model/transformer/rotary.h"
#include "model/transformer/transformer_support.h"

namespace uwv::model {
namespace {

using uwv::testing::cases_in;
using uwv::testing::fixture_folder;
using uwv::testing::GoldenCase;
using uwv::testing::near;
using uwv::testing::rms;

constexpr double tolerance = 1e-4, rotary_tolerance = 1e-6, bf16_rms = 0.03;

class TransformerParity : public ::testing::TestWithParam<std::string> {
 protected:
  TransformerParity() : scope_(1) {}
  std::string folder() const { return fixture_folder("transformer") + "/" + GetParam(); }
  TorchScope scope_;
};

TEST_P(TransformerParity, EveryIntermediateIsTheOfficialOne) {
  const WanTransformer network = WanTransformer::open(folder(), {});
  EXPECT_TRUE(network.warnings().empty());
  for (const std::string& path : cases_in(folder())) {
    const GoldenCase golden(path);
    if (golden.is_bf16()) continue;
    std::set<std::string> seen{"out"};
    TransformerHooks hooks;
    hooks.inspect = [&](const std::string& name, const at::Tensor& value) {
      seen.insert(name);
      ASSERT_TRUE(golden.get(name).defined()) << name;
      EXPECT_TRUE(near(value, golden.get(name), tolerance)) << path << ": " << name;
    };
    TransformerContext context = golden.prepare(network);
    EXPECT_TRUE(near(golden.forward(network, context, hooks), golden.get("out"), tolerance)) << path;
    for (const std::string& name : golden.names())
      EXPECT_TRUE(seen.contains(name) || name.starts_with("in.") || name.starts_with("rope")) << path << ": " << name;
    // The second step of a clip finds the keys of the first.
    EXPECT_TRUE(near(golden.forward(network, context), golden.get("out"), tolerance)) << path << ", again";
  }
}

TEST_P(TransformerParity, RotaryTablesAreTheOfficialOnes) {
  const TransformerConfig config = TransformerConfig::read(folder());
  for (const std::string& path : cases_in(folder())) {
    const GoldenCase golden(path);
    const at::Tensor latents = golden.in("hidden_states");
    const TokenGrid grid{latents.size(2) / config.patch[0], latents.size(3) / config.patch[1],
                         latents.size(4) / config.patch[2]};
    const RotaryTables ours = rotary_tables(grid, config.head_dim);
    if (const at::Tensor both = golden.get("rope_complex64x2"); both.defined()) {
      EXPECT_TRUE(near(ours.cosine, both.select(-1, 0).reshape(ours.cosine.sizes()), rotary_tolerance));
      EXPECT_TRUE(near(ours.sine, both.select(-1, 1).reshape(ours.sine.sizes()), rotary_tolerance));
    }
    if (!golden.get("rope_cos").defined()) continue;
    const auto every_second = [&](const char* name) {
      return golden.get(name).slice(-1, 0, config.head_dim, 2).reshape(ours.cosine.sizes());
    };
    EXPECT_TRUE(near(ours.cosine, every_second("rope_cos"), rotary_tolerance)) << path;
    EXPECT_TRUE(near(ours.sine, every_second("rope_sin"), rotary_tolerance)) << path;
  }
}

TEST_P(TransformerParity, BlocksOnDemandGiveTheSameBits) {
  const WanTransformer kept = WanTransformer::open(folder(), {});
  TransformerOptions options;
  options.streamed = true;
  options.keep_keys = false;
  const WanTransformer streamed = WanTransformer::open(folder(), options);
  for (const std::string& path : cases_in(folder())) {
    const GoldenCase golden(path);
    EXPECT_TRUE(at::equal(golden.run(kept), golden.run(streamed))) << path;
  }
}

TEST_P(TransformerParity, FeedForwardInPiecesAndTwoThreadsGiveTheSame) {
  const WanTransformer network = WanTransformer::open(folder(), {});
  TransformerOptions options;
  options.ffn_rows = 5;
  const WanTransformer pieces = WanTransformer::open(folder(), options);
  for (const std::string& path : cases_in(folder())) {
    const GoldenCase golden(path);
    const at::Tensor once = golden.run(network);
    EXPECT_TRUE(at::equal(once, golden.run(network))) << path;
    EXPECT_TRUE(near(golden.run(pieces), once, 2e-5)) << path;
    const TorchScope two(2);
    EXPECT_TRUE(near(golden.run(network), once, 2e-5)) << path;
  }
}

TEST_P(TransformerParity, LowPrecisionStaysNearTheExactAnswer) {
  const WanTransformer exact = WanTransformer::open(folder(), {});
  const std::map<LinearForm, double> allowed{{LinearForm::bf16_stored, 0.02},
                                             {LinearForm::bf16, bf16_rms},
                                             {LinearForm::int8_stored, 0.03},
                                             {LinearForm::int8, 0.06}};
  for (const auto& [form, most] : allowed) {
    TransformerOptions options;
    options.form = form;
    const WanTransformer network = WanTransformer::open(folder(), options);
    for (const std::string& path : cases_in(folder())) {
      const GoldenCase golden(path);
      const at::Tensor want = golden.run(exact);
      const double error = rms(golden.run(network) - want) / rms(want);
      EXPECT_LT(error, most) << to_string(form) << " " << path;
      EXPECT_GT(error, 0) << to_string(form) << " " << path;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Official, TransformerParity, ::testing::ValuesIn(uwv::testing::transformers()),
                         [](const auto& suite) { return suite.param; });

TEST(ShardedTransformerParity, ShardsAreTheSameNetwork) {
  const TorchScope scope(1);
  const std::vector<std::string> names = uwv::testing::transformers(true);
  ASSERT_FALSE(names.empty());
  for (const std::string& name : names) {
    const std::string shards = fixture_folder("transformer") + "/" + name;
    const std::string whole = shards.substr(0, shards.size() - std::string("_sharded").size());
    const WanTransformer one = WanTransformer::open(whole, {});
    const WanTransformer many = WanTransformer::open(shards, {});
    for (const std::string& path : cases_in(whole)) {
      const GoldenCase golden(path);
      EXPECT_TRUE(near(golden.run(many), golden.get("out"), tolerance)) << path;
      EXPECT_TRUE(at::equal(golden.run(one), golden.run(many))) << path;
    }
  }
}

TEST(Bf16TransformerParity, TheOfficialBf16RunIsMet) {
  const TorchScope scope(1);
  const std::string folder = fixture_folder("transformer") + "/uniview";
  TransformerOptions options;
  options.form = LinearForm::bf16;
  const WanTransformer network = WanTransformer::open(folder, options);
  int met = 0;
  for (const std::string& path : cases_in(folder)) {
    const GoldenCase golden(path);
    if (!golden.is_bf16()) continue;
    ++met;
    EXPECT_LT(rms(golden.run(network) - golden.get("out")), bf16_rms) << path;
  }
  EXPECT_GT(met, 0);
}

}  // namespace
}  // namespace uwv::model
