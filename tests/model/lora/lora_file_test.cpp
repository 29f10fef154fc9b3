// SPDX-License-Identifier: Apache-2.0
#include "model/lora/lora_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "model/complaint.h"
#include "model/lora/fused_weights.h"
#include "model/tensor_support.h"
#include "support/temp_folder.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using uwv::test::TempFolder;
using uwv::testing::near;
using uwv::testing::write_safetensors;
using Tensors = std::map<std::string, at::Tensor>;

LoraFile read(const Tensors& tensors) {
  const TempFolder folder;
  write_safetensors(folder.file("lora.safetensors"), tensors);
  return LoraFile::open(folder.file("lora.safetensors"));
}

std::string complaint(const std::function<void()>& act) {
  return uwv::testing::complaint(act, ErrorCode::value_invalid);
}

TEST(LoraFile, EveryDialectMeansTheSameLayer) {
  const at::Tensor down = at::randn({2, 6}), up = at::randn({4, 2});
  const std::vector<std::pair<std::string, std::string>> dialects{
      {"diffusion_model.blocks.3.self_attn.q.lora_A.weight", "diffusion_model.blocks.3.self_attn.q.lora_B.weight"},
      {"diffusion_model.blocks.3.self_attn.q.lora_down.weight", "diffusion_model.blocks.3.self_attn.q.lora_up.weight"},
      {"blocks.3.self_attn.q.lora_down.weight", "blocks.3.self_attn.q.lora_up.weight"},
      {"transformer.blocks.3.attn1.to_q.lora_A.weight", "transformer.blocks.3.attn1.to_q.lora_B.weight"},
      {"blocks.3.attn1.to_q.lora_A.default.weight", "blocks.3.attn1.to_q.lora_B.default.weight"}};
  for (const auto& [first, second] : dialects) {
    const LoraFile lora = read({{first, down}, {second, up}});
    ASSERT_EQ(lora.layers().size(), 1U) << first;
    const auto& [name, layer] = *lora.layers().begin();
    EXPECT_EQ(name, "blocks.3.attn1.to_q");
    EXPECT_TRUE(at::equal(layer.down, down));
    EXPECT_TRUE(at::equal(layer.up, up));
    EXPECT_EQ(layer.scale, 1);
  }
}

TEST(LoraFile, AlphaIsDividedByTheRankAndNormsAreLeftOut) {
  const LoraFile lora = read({{"diffusion_model.head.head.lora_down.weight", at::ones({4, 6})},
                              {"diffusion_model.head.head.lora_up.weight", at::ones({8, 4})},
                              {"diffusion_model.head.head.alpha", at::scalar_tensor(2)},
                              {"diffusion_model.time_projection.1.diff_b", at::ones({12})},
                              {"diffusion_model.blocks.0.self_attn.norm_q.diff", at::ones({6})},
                              {"diffusion_model.blocks.0.norm3.diff_b", at::ones({6})}});
  EXPECT_EQ(lora.layers().at("proj_out").scale, 0.5);
  EXPECT_TRUE(lora.layers().at("condition_embedder.time_proj").bias.defined());
  EXPECT_EQ(lora.layers().size(), 2U);
  EXPECT_THAT(lora.left_out(),
              ElementsAre("diffusion_model.blocks.0.norm3.diff_b", "diffusion_model.blocks.0.self_attn.norm_q.diff"));
}

TEST(LoraFile, WhatIsNoLoraIsNamed) {
  EXPECT_THAT(complaint([] {
                read({{"blocks.0.attn1.to_q.weight", at::ones({2, 2})}});
              }),
              HasSubstr("blocks.0.attn1.to_q.weight"));
  EXPECT_THAT(complaint([] {
                read({{"blocks.0.attn1.to_q.lora_A.weight", at::ones({2, 2})}});
              }),
              HasSubstr("only one of its two factors"));
  EXPECT_THAT(complaint([] {
                read({{"a.lora_A.weight", at::ones({2, 6})}, {"a.lora_B.weight", at::ones({4, 3})}});
              }),
              HasSubstr("no rank in common"));
  EXPECT_THAT(complaint([] {
                read({{"a.lora_A.weight", at::ones({2})}, {"a.lora_B.weight", at::ones({2})}});
              }),
              HasSubstr("no rank in common"));
  EXPECT_THAT(complaint([] { read({{"a.alpha", at::ones({2})}}); }), HasSubstr("2 values"));
}

class Fused : public ::testing::Test {
 protected:
  Fused() { write_safetensors(folder_.file("m.safetensors"), weights_); }
  FusedWeights weights() const { return FusedWeights(WeightFiles::open(folder_.file("m.safetensors"))); }
  static WeightedLora lora(const std::string& layer, std::int64_t out, std::int64_t in, double weight = 1) {
    return {read({{layer + ".lora_A.weight", at::ones({1, in})}, {layer + ".lora_B.weight", at::ones({out, 1})}}),
            weight};
  }

  TempFolder folder_;
  Tensors weights_{{"l.weight", at::randn({3, 2}).to(at::kBFloat16)}, {"l.bias", at::randn({3})}};
};

TEST_F(Fused, SeveralAddUpInFloat32) {
  FusedWeights fused = weights();
  fused.set_changes({lora("l", 3, 2, 0.25), lora("l", 3, 2, -0.75)});
  EXPECT_EQ(fused.tensor("l.weight").scalar_type(), at::kFloat);
  EXPECT_TRUE(near(fused.tensor("l.weight"), weights_["l.weight"].to(at::kFloat) - 0.5, 1e-6));
  EXPECT_TRUE(at::equal(fused.tensor("l.bias"), weights_["l.bias"]));
  fused.set_changes({});
  EXPECT_TRUE(at::equal(fused.tensor("l.weight"), weights_["l.weight"]));
}

TEST_F(Fused, LayersThatDoNotFitAreNamedAndLeaveTheOldOnes) {
  FusedWeights fused = weights();
  fused.set_changes({lora("l", 3, 2)});
  const at::Tensor before = fused.tensor("l.weight");
  EXPECT_THAT(complaint([&] { fused.set_changes({lora("other", 3, 2)}); }), HasSubstr("other.weight is not"));
  EXPECT_THAT(complaint([&] { fused.set_changes({lora("l", 4, 2)}); }), HasSubstr("would need [4, 2] but is [3, 2]"));
  EXPECT_THAT(complaint([&] {
                fused.set_changes({{read({{"l.diff_b", at::ones({2})}}), 1}});
              }),
              HasSubstr("l.bias has other than 2 values"));
  EXPECT_TRUE(at::equal(fused.tensor("l.weight"), before));
}

}  // namespace
}  // namespace uwv::model
