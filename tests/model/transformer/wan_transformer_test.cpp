// SPDX-License-Identifier: Apache-2.0
#include "model/transformer/wan_transformer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "model/complaint.h"
#include "model/layers/token_kernels.h"
#include "model/layers/torch_scope.h"
#include "model/transformer/tiny_model.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using uwv::testing::complaint;
using uwv::testing::near;
using uwv::testing::Tensors;
using uwv::testing::TinyInputs;
using uwv::testing::TinyModel;

const std::string official = R"("vace_layers": [0, 2], "uniview_ref_num_inject": 1)";
const std::string paper = R"("vace_layers": [0, 2], "uniview_ref_branch": "dit", "uniview_ref_dit_layers": [1])";

class Transformer : public ::testing::Test {
 protected:
  Transformer() : scope_(1) {}

  TorchScope scope_;
};

TEST_F(Transformer, AClosedGateIsTheNetworkWithoutReference) {
  for (const std::string& branch : {official, paper}) {
    const TinyModel closed(branch, [](Tensors& t) { t["uniview_ref_gates"].zero_(); });
    const TinyModel open(branch);
    TinyInputs in;
    const at::Tensor with_closed = in.run(closed.open()), with_open = in.run(open.open());
    in.reference = at::Tensor();
    EXPECT_TRUE(at::equal(with_closed, in.run(open.open()))) << branch;
    EXPECT_FALSE(near(with_open, with_closed, 1e-3)) << branch;
  }
}

TEST_F(Transformer, ReferenceAttentionOfEqualValuesAddsThemTimesTheGate) {
  // Whatever is attended to, a mean of equal values is that value; to_out passes it on.
  const at::Tensor value = at::linspace(-2, 3, 24);
  const std::string behind_the_last =
      R"("vace_layers": [0, 1], "uniview_ref_branch": "dit", "uniview_ref_dit_layers": [2])";
  const TinyModel model(behind_the_last, [&](Tensors& t) {
    t["uniview_ref_attn.0.attn.to_v.weight"].zero_();
    t["uniview_ref_attn.0.attn.to_v.bias"].copy_(value);
    t["uniview_ref_attn.0.attn.to_out.0.weight"].copy_(at::eye(24));
    t["uniview_ref_attn.0.attn.to_out.0.bias"].zero_();
    t["uniview_ref_gates"].fill_(0.5);
  });
  std::map<std::string, at::Tensor> seen;
  TransformerHooks hooks;
  hooks.inspect = [&](const std::string& name, const at::Tensor& x) { seen[name] = x.clone(); };
  TinyInputs().run(model.open(), hooks);
  EXPECT_TRUE(near(seen.at("ref_attn_00"), value.expand_as(seen.at("ref_attn_00")), 1e-5));
  EXPECT_TRUE(near(seen.at("norm_out"), at::layer_norm(seen.at("block_02") + 0.5 * value, {24}, {}, {}, 1e-6), 1e-5));
}

TEST_F(Transformer, AStageOneCheckpointRunsWithoutItsReferenceBranchAndSaysSo) {
  const TinyModel stage_one(official, [](Tensors& t) {
    std::erase_if(t, [](const auto& entry) { return entry.first.find("ref_") != std::string::npos; });
  });
  const WanTransformer network = stage_one.open();
  EXPECT_EQ(network.config().reference, ReferenceBranch::none);
  EXPECT_THAT(network.warnings(), ElementsAre(HasSubstr("stage-1")));
  TinyInputs in;
  const at::Tensor with = in.run(network);
  in.reference = at::Tensor();
  EXPECT_TRUE(at::equal(with, in.run(network)));
}

TEST_F(Transformer, AMissingReferenceEmbedderIsLentTheLatents) {
  const TinyModel lacking(official, [](Tensors& t) {
    t.erase("ref_patch_embedding.weight");
    t.erase("ref_patch_embedding.bias");
  });
  const TinyModel copied(official, [](Tensors& t) {
    t["ref_patch_embedding.weight"] = t["patch_embedding.weight"];
    t["ref_patch_embedding.bias"] = t["patch_embedding.bias"];
  });
  EXPECT_THAT(lacking.open().warnings(), ElementsAre(HasSubstr("ref_patch_embedding")));
  EXPECT_TRUE(at::equal(TinyInputs().run(lacking.open()), TinyInputs().run(copied.open())));
}

TEST_F(Transformer, UnknownMissingAndMisshapedTensorsAreNamed) {
  const TinyModel more(official, [](Tensors& t) { t["blocks.0.extra"] = at::ones({1}); });
  EXPECT_THAT(more.open().warnings(), ElementsAre(HasSubstr("blocks.0.extra")));
  const TinyModel fewer(official, [](Tensors& t) { t.erase("blocks.1.attn2.norm_k.weight"); });
  EXPECT_THAT(complaint([&] { fewer.open(); }), HasSubstr("blocks.1.attn2.norm_k.weight"));
  const TinyModel other(official, [](Tensors& t) { t["vace_blocks.1.proj_out.bias"] = at::ones({3}); });
  EXPECT_THAT(complaint([&] { other.open(); }), HasSubstr("vace_blocks.1.proj_out.bias [3] instead of [24]"));
}

TEST_F(Transformer, OneTokenAndTheEndsOfTimeStayFinite) {
  for (const std::string& branch : {official, paper}) {
    const TinyModel model(branch);
    for (const double t : {0.0, 1000.0}) {
      TinyInputs in(1, 2, 2);
      in.timestep = at::full({1}, t);
      const at::Tensor v = in.run(model.open());
      EXPECT_EQ(v.sizes(), in.latents.sizes());
      EXPECT_TRUE(all_finite(v.contiguous()));
      in.latents.zero_();
      in.control.zero_();
      in.text.zero_();
      EXPECT_TRUE(all_finite(in.run(model.open()).contiguous()));
    }
  }
}

TEST_F(Transformer, MoreThan32768TokensAndPositionsBeyondAThousandRun) {
  const TinyModel model("", {}, 1);
  const WanTransformer network = model.open();
  TinyInputs in(1, 2 * 130, 2 * 254);
  EXPECT_TRUE(all_finite(in.run(network).contiguous()));
  TinyInputs wide(1, 2, 2 * 1100);
  EXPECT_TRUE(all_finite(wide.run(network).contiguous()));
}

TEST_F(Transformer, NumbersThatStopBeingFiniteAreNamedByTheirBlock) {
  const TinyModel model;
  TinyInputs in;
  in.latents[0][0][0][0][0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(complaint([&] { in.run(model.open()); }), HasSubstr("VACE block 0"));
  const TinyModel huge(official, [](Tensors& t) { t["blocks.1.ffn.net.2.weight"].fill_(3e38); });
  for (const LinearForm form : {LinearForm::f32, LinearForm::bf16}) {
    TransformerOptions options;
    options.form = form;
    EXPECT_THAT(complaint([&] { TinyInputs().run(huge.open(options)); }), HasSubstr("after block 1;"));
  }
}

TEST_F(Transformer, TheCallerIsAskedBeforeEachBlockAndMayStop) {
  const TinyModel model;
  std::vector<std::string> names;
  double last = -1;
  TransformerHooks hooks;
  hooks.between = [&](std::string_view name, double done) {
    names.emplace_back(name);
    EXPECT_GT(done, last);
    EXPECT_LT(done, 1);
    last = done;
    if (name == "block 1") fail(ErrorCode::cancelled, "enough");
  };
  EXPECT_EQ(complaint([&] { TinyInputs().run(model.open(), hooks); }), "enough");
  EXPECT_THAT(names, ElementsAre("VACE block 0", "block 0", "block 1"));
}

TEST_F(Transformer, BlocksLeftOutAddWhatTheyAddedLastTime) {
  const TinyModel model;
  const WanTransformer network = model.open();
  const TinyInputs in;
  TransformerContext context = network.prepare(in.control, in.reference, in.text);
  int asked = 0;
  TransformerHooks hooks;
  hooks.skip_blocks = [&](const at::Tensor& modulated) {
    ++asked;
    EXPECT_EQ(modulated.sizes().vec(), (std::vector<std::int64_t>{1, 12, 24}));
    return true;
  };
  const at::Tensor first = network.forward(context, in.latents, in.timestep, hooks);
  EXPECT_EQ(asked, 0);
  EXPECT_TRUE(at::equal(first, in.run(network)));
  hooks.between = [](std::string_view, double) { FAIL() << "a block ran"; };
  EXPECT_TRUE(near(network.forward(context, in.latents, in.timestep, hooks), first, 1e-5));
  EXPECT_EQ(asked, 1);
  // Other latents: the same change on top of other tokens.
  EXPECT_FALSE(near(network.forward(context, in.latents * 2, in.timestep, hooks), first, 1e-3));
}

TEST_F(Transformer, AnotherTextSharesAllElse) {
  const TinyModel model;
  const WanTransformer network = model.open();
  TinyInputs in;
  TransformerContext first = network.prepare(in.control, in.reference, in.text);
  const at::Tensor one = network.forward(first, in.latents, in.timestep);
  in.text = in.text.neg();
  TransformerContext second = network.with_text(first, in.text);
  EXPECT_EQ(second.control.data_ptr(), first.control.data_ptr());
  const at::Tensor two = network.forward(second, in.latents, in.timestep);
  EXPECT_TRUE(at::equal(two, in.run(network)));
  EXPECT_FALSE(near(one, two, 1e-3));
}

TEST_F(Transformer, TokensThatAreLeftOutAreAsIfTheyHadNeverBeen) {
  // A clip of which only the first frame is kept is that frame alone: its positions are the same.
  for (const std::string& branch : {official, paper})
    for (const bool streamed : {false, true}) {
      TransformerOptions options;
      options.streamed = streamed;
      const WanTransformer network = TinyModel(branch).open(options);
      const TinyInputs clip(3, 4, 6, 2);
      TransformerContext context = network.prepare(clip.control, clip.reference, clip.text);
      context.kept = at::arange(6);
      TinyInputs first = clip;
      first.latents = clip.latents.narrow(2, 0, 1);
      first.control = clip.control.narrow(2, 0, 1);
      const at::Tensor v = network.forward(context, clip.latents, clip.timestep);
      EXPECT_TRUE(near(v.narrow(2, 0, 1), first.run(network), 2e-5)) << branch;
      EXPECT_EQ(v.narrow(2, 1, 2).abs().max().item<float>(), 0) << branch;
    }
}

TEST_F(Transformer, ToKeepAllTokensGivesTheSameBits) {
  const TinyModel model;
  const WanTransformer network = model.open();
  const TinyInputs in;
  TransformerContext context = network.prepare(in.control, in.reference, in.text);
  context.kept = at::arange(12);
  EXPECT_TRUE(at::equal(network.forward(context, in.latents, in.timestep), in.run(network)));
}

TEST_F(Transformer, BlocksLeftOutKnowTheTokensThatAreKept) {
  const TinyModel model;
  const WanTransformer network = model.open();
  const TinyInputs in;
  TransformerContext context = network.prepare(in.control, in.reference, in.text);
  context.kept = at::tensor({1, 4, 5, 9}, at::kLong);
  TransformerHooks hooks;
  hooks.skip_blocks = [](const at::Tensor& modulated) { return modulated.size(1) == 4; };
  const at::Tensor first = network.forward(context, in.latents, in.timestep, hooks);
  hooks.between = [](std::string_view, double) { FAIL() << "a block ran"; };
  EXPECT_TRUE(near(network.forward(context, in.latents, in.timestep, hooks), first, 1e-5));
}

TEST_F(Transformer, KeptTokensMustBeOfTheClip) {
  const TinyModel model;
  const WanTransformer network = model.open();
  const TinyInputs in;
  for (const at::Tensor& kept : {at::arange(13), at::arange(-1, 4), at::arange(0), at::ones({3}), at::zeros({1, 1})}) {
    TransformerContext context = network.prepare(in.control, in.reference, in.text);
    context.kept = kept;
    EXPECT_THROW(network.forward(context, in.latents, in.timestep), std::invalid_argument);
  }
}

TEST_F(Transformer, TwoInABatchAreTheTwoAlone) {
  const TinyModel model;
  const WanTransformer network = model.open();
  TinyInputs in(2, 4, 6, 2);
  const at::Tensor both = in.run(network);
  for (int i = 0; i < 2; ++i) {
    TinyInputs one = in;
    for (at::Tensor* part : {&one.latents, &one.control, &one.reference, &one.text, &one.timestep})
      *part = part->slice(0, i, i + 1);
    EXPECT_TRUE(near(both.slice(0, i, i + 1), one.run(network), 2e-5));
  }
  // What both share may be given once.
  TinyInputs shared = in;
  shared.control = in.control.slice(0, 0, 1);
  shared.reference = in.reference.slice(0, 0, 1);
  EXPECT_TRUE(near(shared.run(network).slice(0, 0, 1), both.slice(0, 0, 1), 2e-5));
}

TEST_F(Transformer, WhatDoesNotFitIsTheCallersMistake) {
  const TinyModel model;
  const WanTransformer network = model.open();
  const TinyInputs in;
  const auto refused = [&](const std::function<void(TinyInputs&)>& spoil) {
    TinyInputs bad = in;
    spoil(bad);
    EXPECT_THROW(bad.run(network), std::invalid_argument);
  };
  refused([](TinyInputs& i) { i.text = at::zeros({1, 0, 10}); });
  refused([](TinyInputs& i) { i.text = at::zeros({1, 7, 11}); });
  refused([](TinyInputs& i) { i.control = at::Tensor(); });
  refused([](TinyInputs& i) { i.control = at::zeros({1, 95, 2, 4, 6}); });
  refused([](TinyInputs& i) { i.control = at::zeros({1, 96, 3, 4, 6}); });
  refused([](TinyInputs& i) { i.latents = at::zeros({1, 16, 2, 5, 6}); });
  refused([](TinyInputs& i) { i.timestep = at::zeros({2}); });
  refused([](TinyInputs& i) { i.text = at::zeros({2, 7, 10}); });
}

TEST_F(Transformer, WansOwnNamesAreTheSameNetwork) {
  const std::vector<std::pair<std::string, std::string>> names{{"attn1.to_q", "self_attn.q"},
                                                               {"attn1.to_k", "self_attn.k"},
                                                               {"attn1.to_v", "self_attn.v"},
                                                               {"attn1.to_out.0", "self_attn.o"},
                                                               {"attn1.norm", "self_attn.norm"},
                                                               {"attn2.to_q", "cross_attn.q"},
                                                               {"attn2.to_k", "cross_attn.k"},
                                                               {"attn2.to_v", "cross_attn.v"},
                                                               {"attn2.to_out.0", "cross_attn.o"},
                                                               {"attn2.norm", "cross_attn.norm"},
                                                               {"norm2.", "norm3."},
                                                               {"ffn.net.0.proj", "ffn.0"},
                                                               {"ffn.net.2", "ffn.2"}};
  const TinyModel wan(official, [&](Tensors& t) {
    Tensors renamed;
    for (const auto& [name, tensor] : t) {
      std::string own = name;
      for (const auto& [diffusers, theirs] : names)
        if (const auto at = own.find(diffusers); own.find("blocks.") != std::string::npos && at != std::string::npos)
          own.replace(at, diffusers.size(), theirs);
      renamed["model.diffusion_model." + own] = tensor;
    }
    EXPECT_TRUE(renamed.contains("model.diffusion_model.blocks.0.norm3.weight"));
    t = renamed;
  });
  EXPECT_TRUE(wan.open().warnings().empty());
  EXPECT_TRUE(at::equal(TinyInputs().run(wan.open()), TinyInputs().run(TinyModel().open())));
}

TEST_F(Transformer, WeightsOfEveryStoredTypeRun) {
  const TinyInputs in;
  const at::Tensor exact = in.run(TinyModel().open());
  for (const auto& [type, most] : {std::pair{at::kHalf, 0.01}, {at::kBFloat16, 0.05}, {at::kFloat8_e4m3fn, 0.5}}) {
    const TinyModel stored(official, [&, t = type](Tensors& tensors) {
      for (auto& [name, tensor] : tensors) tensor = tensor.to(t);
    });
    const at::Tensor v = in.run(stored.open());
    EXPECT_LT(((v - exact).square().mean().sqrt() / exact.square().mean().sqrt()).item<double>(), most) << type;
  }
}

}  // namespace
}  // namespace uwv::model
