// SPDX-License-Identifier: Apache-2.0
#include "uwv/model/foreground_network.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "model/script_nets.h"
#include "support/recording_monitor.h"

namespace uwv {
namespace {

using test::NetFolder;
using testing::HasSubstr;

/// The left half red, the right half black.
ImageRgb half_red(Size size) {
  ImageRgb picture(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width / 2; ++x) picture(x, y) = {255, 0, 0};
  return picture;
}

constexpr const char* manifest = R"({"format": 1, "name": "red is near", "kind": "foreground",
  "input": {"resize": "longer_side", "side": 32, "filter": "area"}, "outputs": {"mask": 0}})";

TEST(ForegroundNetwork, FindsWhatTheNetSays) {
  const NetFolder net("def forward(self, x):\n    return x[:, 0:1]\n", manifest);
  const auto finder = open_foreground_network(net.path(), 1);
  EXPECT_EQ(finder->name(), "red is near");
  const Foreground found = find_foreground(half_red({64, 48}), *finder);
  EXPECT_NEAR(found.share, 0.5, 0.02);
  EXPECT_EQ(found.mask(3, 20), 1);
  EXPECT_EQ(found.mask(60, 20), 0);
}

TEST(ForegroundNetwork, ReadsLogitsAndTakesNoNumberForBackground) {
  const NetFolder net("def forward(self, x):\n    return torch.log(x[:, 0:1] - 0.5) * 0.0 + x[:, 0:1] * 20.0 - 10.0\n",
                      R"({"format": 1, "kind": "foreground", "mask_rule": "logit",
                          "input": {"resize": "fixed", "size": [64, 48]}, "outputs": {"mask": 0}})");
  const Image<float> found = open_foreground_network(net.path(), 1)->find(half_red({64, 48}));
  EXPECT_NEAR(found(3, 20), 1, 1e-3) << "the logit is 10";
  EXPECT_EQ(found(60, 20), 0) << "the logarithm of less than nothing is no number";
}

/// Follows the colour at the point, one answer a call: where the frame's red is that of the first frame's pixel.
constexpr const char* same_red = R"(def forward(self, clip, points):
    out = torch.zeros([clip.shape[0], clip.shape[2], clip.shape[3]])
    for i in range(points.shape[0]):
        x = int(points[i, 0].round())
        y = int(points[i, 1].round())
        wanted = clip[0, 0, y, x]
        out = torch.maximum(out, (torch.abs(clip[:, 0] - wanted) < 0.02).float())
    return out.unsqueeze(1)
)";
constexpr const char* segmenter = R"({"format": 1, "name": "same red", "kind": "segmenter",
  "input": {"resize": "fixed", "size": [32, 24], "filter": "area", "layout": "TCHW"}, "outputs": {"mask": 0}PROMPTS})";

std::string with_prompts(const std::string& text) {
  std::string manifest_text = segmenter;
  manifest_text.replace(manifest_text.find("PROMPTS"), 7, text);
  return manifest_text;
}

TEST(ForegroundTracker, UnitesWhatEachPromptBelongsTo) {
  // Two squares of different reds that move to the right.
  std::vector<ImageRgb> frames;
  for (int i = 0; i < 3; ++i) {
    ImageRgb& frame = frames.emplace_back(Size{64, 48});
    for (int y = 8; y < 24; ++y)
      for (int x = 0; x < 16; ++x) frame(x + 8 * i, y) = {200, 0, 0}, frame(x + 8 * i, y + 24) = {100, 0, 0};
  }
  const PixelIndex prompts[] = {{8, 16}, {8, 40}};
  test::RecordingMonitor monitor;
  for (const char* rule : {"", R"(, "prompts": "together")"}) {
    const NetFolder net(same_red, with_prompts(rule));
    const auto tracker = open_foreground_tracker(net.path(), 1);
    const auto masks = tracker->follow(frames, prompts, monitor);
    ASSERT_EQ(masks.size(), 3U);
    for (int i = 0; i < 3; ++i) {
      const ForegroundMask& mask = masks[static_cast<std::size_t>(i)];
      EXPECT_EQ(mask.size(), (Size{64, 48}));
      EXPECT_EQ(mask(8 * i + 8, 16), 1) << i;
      EXPECT_EQ(mask(8 * i + 8, 40), 1) << i;
      EXPECT_EQ(mask(8 * i + 26, 16), 0) << i;
      EXPECT_NEAR(static_cast<double>(mask.count()), 2 * 16 * 16, 80) << i;
    }
    const auto one = tracker->follow(frames, std::span(prompts).first(1), monitor);
    EXPECT_EQ(one[1](16, 40), 0) << "nobody asked for the second square";
  }
}

TEST(ForegroundTracker, StopsWhenAsked) {
  const NetFolder net(same_red, with_prompts(""));
  class Stopping : public Monitor {
    bool progress(std::string_view, long, long) override { return false; }
  } monitor;
  const std::vector<ImageRgb> frames(2, half_red({64, 48}));
  const PixelIndex prompts[] = {{8, 16}};
  EXPECT_THROW(open_foreground_tracker(net.path(), 1)->follow(frames, prompts, monitor), Error);
}

std::string refusal(const NetFolder& net, bool tracker = false) {
  try {
    if (tracker)
      open_foreground_tracker(net.path());
    else
      open_foreground_network(net.path());
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(ForegroundNetwork, RefusesNetworksOfAnotherKind) {
  const char* identity = "def forward(self, x):\n    return x\n";
  EXPECT_THAT(refusal(NetFolder(same_red, with_prompts(""))), HasSubstr("--segmenter"));
  EXPECT_THAT(refusal(NetFolder(identity, manifest), true), HasSubstr("--saliency-model"));
  EXPECT_THAT(refusal(NetFolder(same_red, manifest)), HasSubstr("forward takes 2 inputs"));
  EXPECT_THAT(refusal(NetFolder(identity, with_prompts("")), true), HasSubstr("forward takes 1 inputs"));
  EXPECT_THAT(refusal(NetFolder(identity, R"({"format": 1, "kind": "foreground", "outputs": {"mask": 0},
      "input": {"resize": "fixed", "size": [4, 4], "layout": "TCHW"}})")),
              HasSubstr("no T"));
  EXPECT_THAT(refusal(NetFolder(identity, R"({"format": 1, "kind": "foreground", "outputs": {"mask": 0},
      "prompts": "each", "input": {"resize": "fixed", "size": [4, 4]}})")),
              HasSubstr("'segmenter'"));
}

TEST(ForegroundNetwork, RefusesAnswersOfAnotherShape) {
  const NetFolder net("def forward(self, x):\n    return x\n", manifest);
  EXPECT_THROW(open_foreground_network(net.path())->find(half_red({64, 48})), Error) << "three channels are no mask";
}

}  // namespace
}  // namespace uwv
