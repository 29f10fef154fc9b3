// SPDX-License-Identifier: Apache-2.0
#include "model/transformer/transformer_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "model/tensor_support.h"
#include "model/transformer/transformer_shapes.h"
#include "support/matchers.h"
#include "support/temp_folder.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using uwv::test::TempFolder;
using uwv::testing::write_text;

TransformerConfig read(const std::string& json) {
  const TempFolder folder;
  write_text(folder.file("config.json"), json);
  return TransformerConfig::read(folder.path().string());
}

std::string complaint(const std::string& json) {
  try {
    read(json);
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "taken: " << json;
  return "";
}

std::int64_t values(const TransformerConfig& config) {
  std::int64_t sum = 0;
  for (const auto& [name, shape] : transformer_shapes(config))
    sum += std::accumulate(shape.begin(), shape.end(), std::int64_t{1}, std::multiplies<>());
  return sum;
}

TEST(TransformerConfig, PublishedModelsHaveTheirPublishedSizes) {
  TransformerConfig small = TransformerConfig::wan_1_3b();
  EXPECT_EQ(small.parameters(), 2'153'972'032);
  EXPECT_EQ(values(small), small.parameters());
  small.reference = ReferenceBranch::hint;
  small.ref_at = {0, 2, 4, 6};
  EXPECT_EQ(small.parameters(), 2'191'882'052);
  TransformerConfig large = TransformerConfig::wan_14b();
  EXPECT_EQ(large.parameters(), 17'757'560'900);
  EXPECT_EQ(values(large), large.parameters());
  large.reference = ReferenceBranch::none;
  EXPECT_EQ(large.parameters(), 17'337'592'896);
  large.vace_layers.clear();
  EXPECT_EQ(large.parameters(), 14'288'491'584);
}

TEST(TransformerConfig, AnEmptyConfigIsThe14BTrunkAndNullMeansTheDefault) {
  const TransformerConfig config = read(R"({"ffn_dim": null, "image_dim": null})");
  EXPECT_EQ(config.parameters(), 14'288'491'584);
  EXPECT_EQ(config.reference, ReferenceBranch::none);
}

TEST(TransformerConfig, HintsToRefineAreThoseThatExist) {
  EXPECT_THAT(read(R"({"vace_layers": [0, 1, 3, 4], "uniview_ref_num_inject": 4})").ref_at, ElementsAre(0, 2));
  EXPECT_THAT(read(R"({"vace_layers": [0, 1, 3, 4], "uniview_ref_num_inject": 1})").ref_at, ElementsAre(0));
  EXPECT_THAT(read(R"({"vace_layers": [0, 1, 3], "uniview_ref_inject_vace_block_indices": [1, 2, 9]})").ref_at,
              ElementsAre(1, 2));
}

TEST(TransformerConfig, ThePapersBranchStandsBetweenMainLayers) {
  const TransformerConfig config = read(R"({"vace_layers": [0, 5, 10], "uniview_ref_branch": "dit"})");
  EXPECT_EQ(config.reference, ReferenceBranch::dit);
  EXPECT_THAT(config.ref_at, ElementsAre(0, 10));
  EXPECT_THAT(read(R"({"uniview_ref_branch": "dit", "uniview_ref_dit_layers": [3, 7]})").ref_at, ElementsAre(3, 7));
}

TEST(TransformerConfig, WhatNoNetworkCanHaveIsNamed) {
  EXPECT_THAT(complaint("[]"), HasSubstr("not a JSON object"));
  EXPECT_THAT(complaint(R"({"ffn_dim": -1})"), HasSubstr("'ffn_dim' is -1"));
  EXPECT_THAT(complaint(R"({"ffn_dim": 1e30})"), HasSubstr("'ffn_dim'"));
  EXPECT_THAT(complaint(R"({"num_layers": "x"})"), HasSubstr("'num_layers'"));
  EXPECT_THAT(complaint(R"({"attention_head_dim": 7})"), HasSubstr("attention_head_dim is 7"));
  EXPECT_THAT(complaint(R"({"patch_size": [1, 2]})"), HasSubstr("three numbers"));
  EXPECT_THAT(complaint(R"({"patch_size": [2, 2, 2]})"), HasSubstr("2 frames"));
  EXPECT_THAT(complaint(R"({"vace_layers": [1, 2]})"), HasSubstr("vace_layers"));
  EXPECT_THAT(complaint(R"({"vace_layers": [0, 40]})"), HasSubstr("vace_layers"));
  EXPECT_THAT(complaint(R"({"vace_layers": [0, 0]})"), HasSubstr("vace_layers"));
  EXPECT_THAT(complaint(R"({"image_dim": 1280})"), HasSubstr("not supported"));
  EXPECT_THAT(complaint(R"({"qk_norm": "layer_norm"})"), HasSubstr("qk_norm"));
  EXPECT_THAT(complaint(R"({"eps": 2})"), HasSubstr("eps"));
  EXPECT_THAT(complaint(R"({"uniview_ref_branch": "both"})"), HasSubstr("uniview_ref_branch"));
  EXPECT_THAT(complaint(R"({"uniview_ref_branch": "dit", "uniview_ref_dit_layers": [50]})"), HasSubstr("reference"));
}

TEST(TransformerConfigParity, TheFixturesWeightsAreTheOnesTheirConfigsWant) {
  for (const char* name : {"t2v", "vace", "uniview"}) {
    const std::string folder = uwv::testing::fixture_folder("transformer") + "/" + name;
    const WeightFiles files = WeightFiles::open(folder + "/diffusion_pytorch_model.safetensors");
    const TransformerConfig config = TransformerConfig::read(folder);
    EXPECT_TRUE(files.check(transformer_shapes(config)).empty()) << name;
    EXPECT_EQ(values(config), config.parameters()) << name;
  }
}

}  // namespace
}  // namespace uwv::model
