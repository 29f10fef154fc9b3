// SPDX-License-Identifier: Apache-2.0
// LoRAs in original Wan names, against what diffusers fuses of them.
#include <gtest/gtest.h>

#include <filesystem>

#include "model/layers/torch_scope.h"
#include "model/transformer/transformer_support.h"

namespace uwv::model {
namespace {

using uwv::testing::cases_in;
using uwv::testing::fixture_folder;
using uwv::testing::GoldenCase;
using uwv::testing::near;

constexpr double official_weight = 0.95;

/// X of every lora_X.safetensors among the fixtures.
std::vector<std::string> loras() {
  std::vector<std::string> found;
  for (const auto& entry : std::filesystem::directory_iterator(fixture_folder("lora"))) {
    const std::string name = entry.path().stem().string();
    if (name.starts_with("lora_")) found.push_back(name.substr(5));
  }
  return found;
}

class LoraParity : public ::testing::TestWithParam<std::string> {
 protected:
  LoraParity() : scope_(1) {}
  std::string path(const std::string& start) const {
    return fixture_folder("lora") + "/" + start + GetParam() + ".safetensors";
  }
  std::string network_folder() const { return fixture_folder("lora") + "/transformer"; }
  WeightedLora lora() const { return {LoraFile::open(path("lora_")), official_weight}; }
  TorchScope scope_;
};

TEST_P(LoraParity, FusedWeightsAreTheOfficialOnesAndTheRestStays) {
  FusedWeights weights(WeightFiles::open(network_folder()));
  weights.set_changes({lora()});
  const WeightFiles golden = WeightFiles::open(path("fused_"));
  for (const std::string& name : golden.names())
    EXPECT_TRUE(near(weights.tensor(name), golden.view(name), 2e-6)) << name;
  for (const std::string& name : weights.files().names())
    EXPECT_TRUE(golden.has(name) || at::equal(weights.tensor(name), weights.files().view(name))) << name;
}

TEST_P(LoraParity, TheAnswerIsTheOfficialOneAndGoesBackBitByBit) {
  const GoldenCase golden(path("case_"));
  for (const bool streamed : {false, true}) {
    TransformerOptions options;
    options.streamed = streamed;
    WanTransformer network = WanTransformer::open(network_folder(), options);
    const at::Tensor without = golden.run(network);
    EXPECT_TRUE(near(without, golden.get("out_without_lora"), 2e-4));
    network.set_loras({lora()});
    EXPECT_TRUE(near(golden.run(network), golden.get("out"), 2e-4));
    network.set_loras({});
    EXPECT_TRUE(at::equal(golden.run(network), without));
    options.loras = {lora()};
    EXPECT_TRUE(near(golden.run(WanTransformer::open(network_folder(), options)), golden.get("out"), 2e-4));
  }
}

TEST_P(LoraParity, TwoHalvesAreOneWhole) {
  FusedWeights whole(WeightFiles::open(network_folder())), halves = whole;
  whole.set_changes({lora()});
  WeightedLora half = lora();
  half.weight /= 2;
  halves.set_changes({half, half});
  for (const std::string& name : whole.files().names())
    EXPECT_TRUE(near(halves.tensor(name), whole.tensor(name), 2e-6)) << name;
}

INSTANTIATE_TEST_SUITE_P(Official, LoraParity, ::testing::ValuesIn(loras()),
                         [](const auto& suite) { return suite.param; });

}  // namespace
}  // namespace uwv::model
