// SPDX-License-Identifier: Apache-2.0
#include "model/depth_manifest.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temp_folder.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

using testing::HasSubstr;

constexpr const char* input = R"("input": {"resize": "shorter_side", "side": 518, "multiple_of": 14})";

std::string complaint(const std::string& text, ErrorCode code = ErrorCode::value_invalid) {
  const test::TempFolder folder;
  const std::string path = folder.write("manifest.json", text);
  try {
    read_depth_manifest(path);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    const std::string sentence = error.what();
    EXPECT_THAT(sentence, HasSubstr(path));
    EXPECT_EQ(sentence.find('\n'), std::string::npos);
    return sentence;
  }
  return "accepted";
}

DepthManifest accepted(const std::string& text) {
  const test::TempFolder folder;
  return read_depth_manifest(folder.write("manifest.json", text));
}

std::string metric(const std::string& more) {
  return std::string(R"({"format": 1, "kind": "metric_depth", )") + input + R"(, "outputs": {"depth": 0})" + more + "}";
}

TEST(DepthManifest, reads_every_field) {
  const DepthManifest m =
      accepted(R"({"format": 1, "name": "Video Depth Anything", "model": "vda.ts", "kind": "inverse_depth",
    "input": {"resize": "shorter_side", "side": 518, "multiple_of": 14, "round": "nearest", "limit_aspect": 1.777,
              "filter": "bicubic", "channels": "bgr", "range": [0, 1], "mean": [0.485, 0.456, 0.406],
              "std": [0.229, 0.224, 0.225], "layout": "NTCHW", "dtype": "bfloat16"},
    "outputs": {"inverse_depth": "disparity", "confidence": 1, "mask": 2},
    "confidence_rule": "from_one", "mask_rule": "logit", "mask_threshold": 0.25,
    "window": {"frames": 32, "overlap": 10, "blend": 8, "keyframes": [0, 12, 24, 25, 26, 27, 28, 29, 30, 31]}})");
  EXPECT_EQ(m.name, "Video Depth Anything");
  EXPECT_EQ(m.model, "vda.ts");
  EXPECT_EQ(m.kind, NetworkKind::inverse_depth);
  EXPECT_EQ(m.input.side, 518);
  EXPECT_EQ(m.input.multiple_of, 14);
  EXPECT_EQ(m.input.limit_aspect, 1.777);
  EXPECT_TRUE(m.input.bgr);
  EXPECT_EQ(m.input.std[2], 0.225);
  EXPECT_TRUE(m.input.takes_clips());
  EXPECT_EQ(m.input.dtype, TensorType::bfloat16);
  EXPECT_EQ(m.outputs.at("inverse_depth").key, "disparity");
  EXPECT_EQ(m.outputs.at("mask").number, 2);
  EXPECT_EQ(m.confidence_rule, ConfidenceRule::from_one);
  EXPECT_TRUE(m.mask_is_logit);
  EXPECT_EQ(m.window->tied(), 2);
  EXPECT_EQ(m.window->step(), 22);
}

TEST(DepthManifest, units_follow_the_kind) {
  EXPECT_TRUE(accepted(metric("")).metric);
  EXPECT_FALSE(accepted(metric(R"(, "unit": "relative")")).metric);
  const std::string points =
      std::string(R"({"format": 1, "kind": "points", )") + input + R"(, "outputs": {"points": 0)";
  EXPECT_FALSE(accepted(points + "}}").metric);
  EXPECT_TRUE(accepted(points + R"(, "metric_scale": 1}})").metric);
}

TEST(DepthManifest, names_the_nearest_known_word) {
  EXPECT_THAT(complaint(metric(R"(, "confidance_rule": "unit")")), HasSubstr("did you mean 'confidence_rule'?"));
  EXPECT_THAT(complaint(R"({"format": 1, "kind": "metric_dept", "input": {}, "outputs": {}})"),
              HasSubstr("did you mean 'metric_depth'?"));
  EXPECT_THAT(
      complaint(R"({"format": 1, "kind": "points", "input": {"resize": "area", "pixels": 9, "chanels": "rgb"}})"),
      HasSubstr("/input/chanels is not a known key (did you mean 'channels'?)"));
  EXPECT_THAT(
      complaint(std::string(R"({"format": 1, "kind": "inverse_depth", )") + input + R"(, "outputs": {"depth": 0}})"),
      HasSubstr("/outputs/depth is not a known key; one of inverse_depth, confidence, mask is wanted"));
}

TEST(DepthManifest, says_what_is_missing) {
  EXPECT_THAT(complaint("{}"), HasSubstr("'format' is missing"));
  EXPECT_THAT(complaint(R"({"format": 1})"), HasSubstr("'kind' is missing"));
  EXPECT_THAT(complaint(R"({"format": 1, "kind": "points", "input": {"resize": "fixed"}})"),
              HasSubstr("'size' is missing"));
  EXPECT_THAT(
      complaint(std::string(R"({"format": 1, "kind": "depth_and_pose", )") + input + R"(, "outputs": {"depth": 0}})"),
      HasSubstr("'pose' is missing"));
}

TEST(DepthManifest, refuses_values_that_cannot_be) {
  for (const char* side : {"0", "-5", "1e9", "99999", "\"518\"", "2.5", "null", "[518]"})
    EXPECT_THAT(
        complaint(std::string(R"({"format": 1, "kind": "metric_depth", "input": {"resize": "width", "side": )") + side +
                  R"(}, "outputs": {"depth": 0}})"),
        HasSubstr("/input/side is"))
        << side;
  EXPECT_THAT(complaint(R"({"format": 2})"), HasSubstr("/format"));
  EXPECT_THAT(complaint(metric(R"(, "model": "../../etc/passwd")")),
              HasSubstr("the name of a file beside the manifest"));
  EXPECT_THAT(complaint(metric(R"(, "mask_threshold": 0.5)")), HasSubstr("without 'outputs/mask'"));
  for (const char* layout : {"HW", "NCHWC", "CTHW", "NCHWX", "", "NNCHW"})
    EXPECT_THAT(
        complaint(std::string(
                      R"({"format": 1, "kind": "metric_depth", "input": {"resize": "width", "side": 9, "layout": ")") +
                  layout + R"("}, "outputs": {"depth": 0}})"),
        HasSubstr("/input/layout"))
        << layout;
  EXPECT_THAT(
      complaint(R"({"format": 1, "kind": "metric_depth", "input": {"resize": "width", "side": 9, "std": [1, 0, 1]},
                          "outputs": {"depth": 0}})"),
      HasSubstr("/input/std/1"));
  EXPECT_THAT(
      complaint(R"({"format": 1, "kind": "metric_depth", "input": {"resize": "width", "side": 9, "size": [3, 3]}})"),
      HasSubstr("'size' has no meaning"));
}

TEST(DepthManifest, refuses_windows_whose_frames_do_not_meet) {
  const auto with = [](const std::string& window) {
    return R"({"format": 1, "kind": "inverse_depth", "input": {"resize": "width", "side": 9, "layout": "NTCHW"},
             "outputs": {"inverse_depth": 0}, "window": )" +
           window + "}";
  };
  EXPECT_THAT(complaint(with(R"({"frames": 8, "overlap": 3, "blend": 2, "keyframes": [1, 6, 7]})")),
              HasSubstr("begin with 0"));
  EXPECT_THAT(complaint(with(R"({"frames": 8, "overlap": 3, "blend": 2, "keyframes": [0, 5, 7]})")),
              HasSubstr("6 to 7"));
  EXPECT_THAT(complaint(with(R"({"frames": 8, "overlap": 3, "keyframes": [0, 7]})")), HasSubstr("'overlap' = 3"));
  EXPECT_THAT(complaint(with(R"({"frames": 8, "overlap": 5})")), HasSubstr("/window/overlap"));
  EXPECT_THAT(complaint(with(R"({"frames": 1000000000, "overlap": 5})")), HasSubstr("/window/frames"));
  EXPECT_EQ(accepted(with(R"({"frames": 8, "overlap": 3})")).window->keyframes, (std::vector<int>{5, 6, 7}));
  EXPECT_THAT(complaint(metric(R"(, "window": {"frames": 8, "overlap": 3})")), HasSubstr("needs a T"));
}

TEST(DepthManifest, that_is_no_json_is_damaged) {
  for (const char* text : {"", "{", "{\"format\": 1,}", "\xff\xfe", "{\"format\": 1, \"format\": 1}"})
    EXPECT_NE(complaint(text, ErrorCode::file_damaged), "accepted") << text;
}

}  // namespace
}  // namespace uwv::model
