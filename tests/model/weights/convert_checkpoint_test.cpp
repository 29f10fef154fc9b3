// SPDX-License-Identifier: Apache-2.0
#include "uwv/model/convert_checkpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "model/complaint.h"
#include "model/layers/torch_scope.h"
#include "model/text/umt5_encoder.h"
#include "model/transformer/tiny_model.h"
#include "support/matchers.h"

namespace uwv::model {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using uwv::testing::complaint;
using uwv::testing::Tensors;
using uwv::testing::TinyInputs;
using uwv::testing::TinyModel;

class Conversion : public ::testing::Test {
 protected:
  Conversion() : scope_(1) {}

  std::string convert(const std::string& from, const std::string& weights, const char* name = "out") {
    const std::string out = folder_.file(name);
    Monitor monitor;
    summary_ = convert_checkpoint({from, weights, out}, monitor);
    return out;
  }
  static at::Tensor velocity(const std::string& folder, LinearForm form, bool streamed = false) {
    TransformerOptions options;
    options.form = form;
    options.streamed = streamed;
    const WanTransformer network = WanTransformer::open(folder, options);
    EXPECT_TRUE(network.warnings().empty());
    return TinyInputs().run(network);
  }
  /// The converted weights of a tiny model, changed.
  std::string spoiled(const std::function<void(Tensors&)>& spoil) {
    const std::string out = convert(TinyModel().path(), "int8", ("spoiled" + std::to_string(++count_)).c_str());
    const std::string file = out + "/diffusion_pytorch_model.safetensors";
    Tensors tensors;
    const SafeTensors stored = SafeTensors::open(file);
    for (const std::string& name : stored.names()) {
      const std::vector<float> values = stored.as_float(name);
      const auto& shape = stored.info(name).shape;
      tensors[name] = at::tensor(values)
                          .view(std::vector<std::int64_t>(shape.begin(), shape.end()))
                          .to(stored.info(name).dtype == DType::i8 ? at::kChar : at::kFloat);
    }
    spoil(tensors);
    uwv::testing::write_safetensors(file, tensors);
    return out;
  }

  TorchScope scope_;
  test::TempFolder folder_;
  ConversionSummary summary_;
  int count_ = 0;
};

TEST_F(Conversion, EightBitsOnDiskAreTheBitsOfRoundingWhenOpened) {
  const TinyModel model;
  const std::string small = convert(model.path(), "int8");
  EXPECT_LT(summary_.bytes_after, summary_.bytes_before);
  EXPECT_GT(summary_.rounded, 40);
  for (const LinearForm form : {LinearForm::int8, LinearForm::int8_stored})
    for (const bool streamed : {false, true})
      EXPECT_TRUE(at::equal(velocity(small, form, streamed), velocity(model.path(), form))) << to_string(form);
  const at::Tensor held = velocity(model.path(), LinearForm::int8_stored);
  EXPECT_TRUE(uwv::testing::near(velocity(small, LinearForm::f32), held, 1e-5));
  EXPECT_TRUE(uwv::testing::near(velocity(small, LinearForm::bf16), held, 0.1));
}

TEST_F(Conversion, SixteenBitsOnDiskAreTheBitsOfRoundingWhenOpened) {
  const TinyModel model;
  const std::string small = convert(model.path(), "bf16");
  EXPECT_LT(summary_.bytes_after, summary_.bytes_before);
  for (const LinearForm form : {LinearForm::bf16, LinearForm::bf16_stored})
    EXPECT_TRUE(at::equal(velocity(small, form), velocity(model.path(), form))) << to_string(form);
}

TEST_F(Conversion, ALoraOnTopIsAddedToTheWidenedWeight) {
  const TinyModel model;
  const std::string small = convert(model.path(), "int8"), file = folder_.file("lora.safetensors");
  const std::string layer = "blocks.1.attn1.to_v.";
  uwv::testing::write_safetensors(file, {{layer + "lora_A.weight", at::linspace(-1, 2, 48).view({2, 24})},
                                         {layer + "lora_B.weight", at::linspace(2, -1, 48).view({24, 2})}});
  TransformerOptions options;
  options.form = LinearForm::int8_stored;
  WanTransformer ours = WanTransformer::open(small, options), whole = WanTransformer::open(model.path(), options);
  const TinyInputs in;
  const at::Tensor plain = in.run(ours);
  ours.set_loras({{LoraFile::open(file), 1}});
  whole.set_loras({{LoraFile::open(file), 1}});
  const at::Tensor changed = in.run(ours);
  const auto effect = (changed - plain).abs().max().item<float>();
  EXPECT_GT(effect, 0.1);
  EXPECT_LT((changed - in.run(whole)).abs().max().item<float>(), effect / 5);
  ours.set_loras({});
  EXPECT_TRUE(at::equal(in.run(ours), plain));
}

TEST_F(Conversion, AWholeCheckpointKeepsItsLayout) {
  const std::string wan = uwv::testing::fixture_folder("pipeline") + "/wan";
  const std::string small = convert(wan, "int8");
  for (const auto& entry : fs::recursive_directory_iterator(wan)) {
    const fs::path name = entry.path().filename();
    const bool wanted = name == "config.json" || name == "tokenizer.json";
    EXPECT_TRUE(!wanted || fs::exists(small / fs::relative(entry.path(), wan))) << entry.path();
  }
  const auto encode = [](const std::string& root) {
    const Umt5Encoder encoder = Umt5Encoder::open(root + "/text_encoder", LinearForm::int8_stored);
    const at::Tensor ids = at::tensor({5, 9, 1}, at::kLong).unsqueeze(0);
    return encoder.encode({{ids, at::ones_like(ids)}}, {}).front();
  };
  EXPECT_TRUE(at::equal(encode(small), encode(wan)));
}

TEST_F(Conversion, WhatCannotBeDoneLeavesNothing) {
  const TinyModel model;
  const std::string small = convert(model.path(), "int8");
  EXPECT_THAT(complaint([&] { convert(small, "int8", "again"); }), HasSubstr("in 8 bits already"));
  EXPECT_THAT(complaint([&] { convert(model.path(), "bf16"); }), HasSubstr("is there already"));
  EXPECT_THAT(complaint([&] { convert("/no/such/folder", "int8", "none"); }), HasSubstr("/no/such/folder"));
  const test::TempFolder empty;
  EXPECT_THAT(complaint([&] { convert(empty.path().string(), "int8", "none"); }), HasSubstr("config.json"));
  Monitor monitor;
  EXPECT_THAT(complaint([&] {
                convert_checkpoint({model.path(), "int8", model.path() + "/in"}, monitor);
              }),
              HasSubstr("lies within"));
  EXPECT_THROW(convert_checkpoint({model.path(), "int4", folder_.file("x")}, monitor), std::invalid_argument);
  struct Stopping : Monitor {
    bool progress(std::string_view, long done, long) override { return done < 3; }
  } stopping;
  EXPECT_THAT(complaint([&] {
                convert_checkpoint({model.path(), "int8", folder_.file("stopped")}, stopping);
              }),
              HasSubstr("stopped"));
  for (const auto& entry : fs::directory_iterator(folder_.path())) EXPECT_EQ(entry.path().filename(), "out");
}

TEST_F(Conversion, ScalesThatAreMissingOrDoNotFitAreNamed) {
  const std::string weight = "blocks.1.attn1.to_q.weight", scales = scales_name(weight);
  const auto refused = [&](const std::function<void(Tensors&)>& spoil) {
    const std::string folder = spoiled(spoil);
    return complaint([&] { WanTransformer::open(folder, {}); });
  };
  EXPECT_THAT(refused([&](Tensors& t) { t.erase(scales); }), HasSubstr(weight + " of I8 without " + scales));
  EXPECT_THAT(refused([&](Tensors& t) { t[scales] = at::ones({3}); }), HasSubstr(scales + " [3] of F32"));
  EXPECT_THAT(refused([&](Tensors& t) { t[scales] = t[scales].to(at::kHalf); }), HasSubstr(scales + " [24] of F16"));
  EXPECT_THAT(refused([&](Tensors& t) { t[weight] = t[weight].to(at::kFloat); }), HasSubstr(scales + " beside"));
  EXPECT_THAT(refused([&](Tensors& t) {
                t["proj_out.bias"] = t["proj_out.bias"].to(at::kChar);
                t[scales_name("proj_out.bias")] = at::ones({64});
              }),
              HasSubstr("only matrices"));
  EXPECT_TRUE(WanTransformer::open(spoiled([](Tensors&) {}), {}).warnings().empty());
}

TEST_F(Conversion, AMatrixThatIsNoLayersIsNotReadWithoutItsScales) {
  const std::string wan = uwv::testing::fixture_folder("pipeline") + "/wan";
  Tensors tensors;
  const WeightFiles files = WeightFiles::open(wan + "/text_encoder");
  for (const std::string& name : files.names()) tensors[umt5_name(name)] = files.load(name, at::kFloat);
  const at::Tensor words = tensors.at("shared.weight");
  const QuantisedWeight rounded = quantised(words);
  tensors["shared.weight"] = rounded.numbers;
  tensors[scales_name("shared.weight")] = rounded.scales;
  tensors.erase("encoder.embed_tokens.weight");
  const std::string file = folder_.file("model.safetensors");
  uwv::testing::write_safetensors(file, tensors);
  const Umt5Encoder encoder = Umt5Encoder::open(file, LinearForm::f32);
  const at::Tensor ids = at::ones({1, 1}, at::kLong);
  EXPECT_THAT(complaint([&] { encoder.encode({{ids, ids}}, {}); }), HasSubstr("'shared.weight' is held in 8 bits"));
}

}  // namespace
}  // namespace uwv::model
