// SPDX-License-Identifier: Apache-2.0
#include "model/weights/weight_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "model/complaint.h"
#include "model/tensor_support.h"
#include "support/temp_folder.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using uwv::test::TempFolder;
using uwv::testing::complaint;
using uwv::testing::write_safetensors;
using uwv::testing::write_text;

TEST(WeightFiles, AFileGivesBackEveryTypeOfNumberUnchanged) {
  const TempFolder folder;
  const at::Tensor values = at::linspace(-3, 3, 12).reshape({3, 4});
  for (const auto type : {at::kFloat, at::kHalf, at::kBFloat16, at::kFloat8_e4m3fn, at::kFloat8_e5m2, at::kDouble}) {
    const std::string path = folder.file("one.safetensors");
    write_safetensors(path, {{"a.weight", values.to(type)}});
    const WeightFiles weights = WeightFiles::open(path);
    EXPECT_EQ(weights.view("a.weight").scalar_type(), type);
    EXPECT_TRUE(at::equal(weights.load("a.weight", at::kFloat), values.to(type).to(at::kFloat))) << type;
  }
}

TEST(WeightFiles, EightBitCodesThatAreNoNumbersStayNone) {
  const TempFolder folder;
  const std::string path = folder.file("f8.safetensors");
  const at::Tensor codes = at::tensor({0x7F, 0xFF, 0x7E, 0x80, 0x01}).to(at::kByte);
  write_safetensors(path, {{"e4m3", codes.view(at::kFloat8_e4m3fn)}, {"e5m2", codes.view(at::kFloat8_e5m2)}});
  const WeightFiles weights = WeightFiles::open(path);
  // E4M3 has no infinities and one NaN of each sign; E5M2 has both.
  const at::Tensor e4m3 = weights.load("e4m3", at::kFloat), e5m2 = weights.load("e5m2", at::kFloat);
  EXPECT_TRUE(at::equal(e4m3.isnan(), at::tensor({1, 1, 0, 0, 0}).to(at::kBool)));
  EXPECT_TRUE(at::equal(e4m3.slice(0, 2), at::tensor({448.0F, -0.0F, 0x1p-9F})));
  EXPECT_TRUE(at::equal(e5m2.isnan(), at::tensor({1, 1, 1, 0, 0}).to(at::kBool)));
  const SafeTensors file = SafeTensors::open(path);
  for (const auto& [name, values] : {std::pair("e4m3", e4m3), std::pair("e5m2", e5m2)}) {
    const std::vector<float> by_hand = file.as_float(name);
    EXPECT_TRUE(at::allclose(at::tensor(by_hand), values, 0, 0, /*equal_nan=*/true)) << name;
  }
}

TEST(WeightFiles, TensorsThatLieAcrossTheirAlignmentAreCopied) {
  const TempFolder folder;
  const std::string path = folder.file("odd.safetensors");
  std::string header = R"({"a":{"dtype":"F32","shape":[2],"data_offsets":[0,8]}})";
  while (header.size() % 4 != 1) header += ' ';
  std::string bytes(8, '\0');
  bytes[0] = static_cast<char>(header.size());
  const std::array<float, 2> values{1.5F, -2};
  bytes.append(header).append(reinterpret_cast<const char*>(values.data()), sizeof values);
  write_text(path, bytes);
  EXPECT_TRUE(at::equal(WeightFiles::open(path).view("a"), at::tensor({1.5F, -2.0F})));
}

TEST(WeightFiles, AFolderOfShardsReadsAsOne) {
  const TempFolder folder;
  write_safetensors(folder.file("m-1.safetensors"), {{"a", at::ones({2})}});
  write_safetensors(folder.file("m-2.safetensors"), {{"b", at::zeros({3})}});
  write_text(folder.file("m.safetensors.index.json"),
             R"({"metadata":{},"weight_map":{"a":"m-1.safetensors","b":"m-2.safetensors"}})");
  const WeightFiles weights = WeightFiles::open(folder.path().string());
  EXPECT_THAT(weights.names(), ElementsAre("a", "b"));
  EXPECT_EQ(weights.bytes(), 20U);
  weights.will_need("a");
  weights.release("a");
  EXPECT_TRUE(at::equal(weights.view("a"), at::ones({2})));
}

TEST(WeightFiles, AFileOfTheUsualNameGoesBeforeOthersAndOthersAreMerged) {
  const TempFolder folder;
  write_safetensors(folder.file("one.safetensors"), {{"a", at::ones({2})}});
  write_safetensors(folder.file("two.safetensors"), {{"b", at::zeros({3})}});
  EXPECT_THAT(WeightFiles::open(folder.path().string()).names(), ElementsAre("a", "b"));
  write_safetensors(folder.file("model.safetensors"), {{"c", at::ones({1})}});
  EXPECT_THAT(WeightFiles::open(folder.path().string()).names(), ElementsAre("c"));
}

TEST(WeightFiles, AnIndexThatDoesNotFitItsShardsIsNamed) {
  const TempFolder folder;
  write_safetensors(folder.file("m-1.safetensors"), {{"a", at::ones({2})}});
  const auto with_index = [&](const std::string& text) {
    write_text(folder.file("m.safetensors.index.json"), text);
    return [&] { WeightFiles::open(folder.path().string()); };
  };
  EXPECT_THAT(
      complaint(with_index(R"({"weight_map":{"a":"m-1.safetensors","b":"m-1.safetensors"}})"), ErrorCode::file_damaged),
      HasSubstr("'b'"));
  EXPECT_THAT(complaint(with_index(R"({"weight_map":{"b":"m-1.safetensors"}})"), ErrorCode::file_damaged),
              HasSubstr("'a'"));
  EXPECT_THAT(complaint(with_index(R"({"weight_map":{"a":"../m-1.safetensors"}})"), ErrorCode::file_damaged),
              HasSubstr("plain file name"));
  EXPECT_THAT(complaint(with_index(R"({"weight_map":[]})"), ErrorCode::file_damaged), HasSubstr("weight_map"));
  complaint(with_index("{"), ErrorCode::file_damaged);
  complaint(with_index(R"({"weight_map":{"a":"gone.safetensors"}})"), ErrorCode::file_not_found);
}

TEST(WeightFiles, PicklesAreRefusedWithTheWayOut) {
  const TempFolder folder;
  write_text(folder.file("diffusion_pytorch_model.bin"), "\x80\x02}q.");
  const auto text = complaint([&] { WeightFiles::open(folder.path().string()); }, ErrorCode::format_unknown);
  EXPECT_THAT(text, HasSubstr("pickle"));
  EXPECT_THAT(text, HasSubstr("save_file"));
  complaint([&] { WeightFiles::open(folder.file("diffusion_pytorch_model.bin")); }, ErrorCode::format_unknown);
}

TEST(WeightFiles, MissingMisshapedAndUnwantedNamesAreEachTold) {
  const TempFolder folder;
  write_safetensors(folder.file("m.safetensors"),
                    {{"a", at::ones({2})}, {"b", at::ones({2, 3})}, {"x", at::ones({1})}});
  const WeightFiles weights = WeightFiles::open(folder.path().string());
  EXPECT_THAT(weights.check({{"a", {2}}, {"b", {2, 3}}}), ElementsAre("x"));
  const auto text = complaint(
      [&] {
        weights.check({{"a", {2}}, {"b", {3, 2}}, {"c", {1}}});
      },
      ErrorCode::value_invalid);
  EXPECT_THAT(text, HasSubstr("lacks 1 tensors: c"));
  EXPECT_THAT(text, HasSubstr("b [2, 3] instead of [3, 2]"));
}

TEST(WeightFiles, NumbersThatAreWrongWithoutScalesBesideThemAreRefused) {
  const TempFolder folder;
  write_safetensors(folder.file("m.safetensors"),
                    {{"a.weight", at::ones({2}).to(at::kFloat8_e4m3fn)}, {"a.scale_weight", at::ones({1})}});
  const WeightFiles weights = WeightFiles::open(folder.path().string());
  EXPECT_THAT(complaint([&] { weights.check({{"a.weight", {2}}}); }, ErrorCode::value_invalid), HasSubstr("scales"));
}

TEST(WeightFiles, RenamingLeavesOutAndRefusesTwins) {
  const TempFolder folder;
  write_safetensors(folder.file("m.safetensors"), {{"a", at::ones({2})}, {"b", at::zeros({2})}});
  WeightFiles weights = WeightFiles::open(folder.path().string());
  complaint([&] { weights.rename([](const std::string&) { return "same"; }); }, ErrorCode::file_damaged);
  weights.rename([](const std::string& name) { return name == "a" ? "first" : ""; });
  EXPECT_THAT(weights.names(), ElementsAre("first"));
  EXPECT_TRUE(at::equal(weights.view("first"), at::ones({2})));
}

}  // namespace
}  // namespace uwv::model
