// SPDX-License-Identifier: Apache-2.0
// Files that are no network, and networks that are not what their manifest says: one clear sentence each.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "model/script_nets.h"
#include "uwv/model/depth_network.h"

namespace uwv {
namespace {

using test::NetFolder;
using test::TempFolder;
using testing::AllOf;
using testing::HasSubstr;

constexpr const char* manifest = R"({"format": 1, "kind": "metric_depth",
  "input": {"resize": "fixed", "size": [8, 6]}, "outputs": {"depth": 0}})";
constexpr const char* good = "def forward(self, x):\n    return 1.0 + x[:, 0]\n";

/// The sentence with which opening the folder and running one frame fails.
std::string complaint(const std::string& folder, ErrorCode code) {
  try {
    ThreadPool pool(1);
    Monitor monitor;
    const std::vector<ImageRgb> frames{ImageRgb(8, 6)};
    open_depth_network(folder)->run(frames, {}, pool, monitor);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    return error.what();
  }
  return "accepted";
}

std::string with_model_bytes(std::string_view bytes, ErrorCode code) {
  const TempFolder folder;
  folder.write("manifest.json", manifest);
  folder.write("model.ts", bytes);
  return complaint(folder.path().string(), code);
}

std::string with_script(const std::string& source, const char* its_manifest = manifest) {
  const NetFolder net(source, its_manifest);
  return complaint(net.path(), ErrorCode::value_invalid);
}

TEST(DepthNetworkFiles, that_are_missing_are_named) {
  const TempFolder folder;
  EXPECT_THAT(complaint(folder.file("none"), ErrorCode::file_not_found), HasSubstr("is no folder"));
  EXPECT_THAT(complaint(folder.path().string(), ErrorCode::file_not_found), HasSubstr("manifest.json: is missing"));
  folder.write("manifest.json", manifest);
  EXPECT_THAT(complaint(folder.path().string(), ErrorCode::file_not_found), HasSubstr("model.ts: is missing"));
  std::filesystem::create_directory(folder.path() / "model.ts");
  EXPECT_THAT(complaint(folder.path().string(), ErrorCode::file_not_found), HasSubstr("is a folder"));
}

TEST(DepthNetworkFiles, that_hold_weights_only_are_told_apart) {
  const TempFolder folder;
  folder.write("manifest.json", manifest);
  test::save_tensor_only(folder.file("model.ts"));
  EXPECT_THAT(complaint(folder.path().string(), ErrorCode::format_unknown), HasSubstr("torch.save"));
  EXPECT_THAT(with_model_bytes(std::string("\x80\x02}q\x00.", 6), ErrorCode::format_unknown),
              HasSubstr("Python pickle"));
  EXPECT_THAT(with_model_bytes(std::string("\x40\0\0\0\0\0\0\0{\"a\":1}", 15), ErrorCode::format_unknown),
              HasSubstr("safetensors"));
  EXPECT_THAT(with_model_bytes("GIF89a", ErrorCode::format_unknown), HasSubstr("not a zip archive"));
  EXPECT_THAT(with_model_bytes("", ErrorCode::file_damaged), HasSubstr("is empty"));
}

TEST(DepthNetworkFiles, that_were_cut_short_or_changed_are_damaged) {
  const NetFolder net(good, manifest);
  const std::string whole = net.files().read("model.ts");
  for (const double part : {0.01, 0.3, 0.7, 0.999}) {
    const auto bytes = whole.substr(0, static_cast<std::size_t>(part * static_cast<double>(whole.size())));
    EXPECT_NE(with_model_bytes(bytes, ErrorCode::file_damaged), "accepted") << part;
  }
  // Any byte may lie: the answer is a sentence or a depth, never a crash.
  for (std::size_t at = 0; at < whole.size(); at += whole.size() / 40) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(~bytes[at]);
    const TempFolder folder;
    folder.write("manifest.json", manifest);
    folder.write("model.ts", bytes);
    try {
      open_depth_network(folder.path().string());
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
}

TEST(DepthNetworkSignature, of_another_kind_is_explained) {
  EXPECT_THAT(with_script("def forward(self, x, tokens):\n    return x[:, 0]\n"), HasSubstr("forward takes 2 inputs"));
  EXPECT_THAT(with_script("def forward(self):\n    return 1.0\n"), HasSubstr("forward takes 0 inputs"));
  EXPECT_THAT(with_script("def infer(self, x):\n    return x\n"), HasSubstr("no method 'forward'"));
  EXPECT_THAT(with_script("def forward(self, x):\n    return 'depth'\n"), HasSubstr("output number 0 is a String"));
  EXPECT_THAT(with_script("def forward(self, x):\n    return torch.matmul(x, torch.ones([77, 3]))\n"),
              AllOf(HasSubstr("failed on an input of [1, 3, 6, 8]"), HasSubstr("compare 'input'")));
  EXPECT_THAT(with_script("def forward(self, x):\n    assert x.size(2) == 518, 'only 518'\n    return x[:, 0]\n"),
              HasSubstr("only 518"));
  EXPECT_THAT(with_script("def forward(self, x):\n    return x[0, 0].to_sparse()\n"), HasSubstr("failed on an input"));
  EXPECT_THAT(with_script("def forward(self, x):\n    return torch.zeros([1]).expand([1, 60000, 60000])\n"),
              HasSubstr("3600000000 numbers"));
}

TEST(DepthNetworkSignature, outputs_that_are_not_as_promised_are_named_with_their_shape) {
  EXPECT_THAT(with_script("def forward(self, x):\n    return x\n"), HasSubstr("has the shape [1, 3, 6, 8]"));
  EXPECT_THAT(with_script("def forward(self, x):\n    return x.sum()\n"), HasSubstr("has the shape []"));
  EXPECT_THAT(with_script("def forward(self, x):\n    return torch.zeros([0, 4])\n"),
              HasSubstr("has the shape [0, 4]"));
  EXPECT_THAT(with_script("def forward(self, x):\n    return {'d': x[:, 0]}\n"), HasSubstr("a dictionary with d"));
  const char* second = R"({"format": 1, "kind": "metric_depth", "input": {"resize": "fixed", "size": [8, 6]},
    "outputs": {"depth": 1}})";
  EXPECT_THAT(with_script(good, second), HasSubstr("returns 1 outputs; 'outputs/depth'"));
  const char* named = R"({"format": 1, "kind": "metric_depth", "input": {"resize": "fixed", "size": [8, 6]},
    "outputs": {"depth": "depth"}})";
  EXPECT_THAT(with_script(good, named), HasSubstr("nothing named 'depth'"));
  const char* masked = R"({"format": 1, "kind": "metric_depth", "input": {"resize": "fixed", "size": [8, 6]},
    "outputs": {"depth": 0, "mask": 1}})";
  EXPECT_THAT(with_script("def forward(self, x):\n    return x[:, 0], x[:, 0, 1:]\n", masked), HasSubstr("one size"));
  const char* points = R"({"format": 1, "kind": "points", "input": {"resize": "fixed", "size": [8, 6]},
    "outputs": {"points": 0}})";
  EXPECT_THAT(with_script("def forward(self, x):\n    return x[:, 0]\n", points), HasSubstr("three channels"));
  EXPECT_THAT(with_script("def forward(self, x):\n    return x * 0.0\n", points), HasSubstr("no focal length fits"));
}

}  // namespace
}  // namespace uwv
