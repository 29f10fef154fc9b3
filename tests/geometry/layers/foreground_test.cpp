// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "uwv/geometry/layers.h"

namespace uwv {
namespace {

ForegroundMask rectangle(Size size, int x0, int y0, int x1, int y1) {
  ForegroundMask mask(size);
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) mask(x, y) = 1;
  return mask;
}

std::vector<PixelIndex> grid(int x0, int x1, int y0, int y1, int step) {
  std::vector<PixelIndex> out;
  for (int y = y0; y <= y1; y += step)
    for (int x = x0; x <= x1; x += step) out.push_back({x, y});
  return out;
}

TEST(Foreground, ThresholdsProbability) {
  Image<float> probability(10, 10, 0.2F);
  for (int x = 0; x < 10; ++x) probability(x, 4) = 0.9F;
  probability(0, 0) = std::numeric_limits<float>::quiet_NaN();
  const Foreground found = foreground_from(probability, "test");
  EXPECT_EQ(found.mask.count(), 10U);
  EXPECT_EQ(found.mask(3, 4), 1);
  EXPECT_DOUBLE_EQ(found.share, 0.1);
  EXPECT_EQ(found.note, "test found a foreground of 10.0 % of the picture");
}

TEST(Foreground, TooLittleIsNothingAndSaysSo) {
  Image<float> probability(100, 10, 0.0F);
  for (int x = 0; x < 49; ++x) probability(x, 4) = 1.0F;
  const Foreground nothing = foreground_from(probability, "test");
  EXPECT_EQ(nothing.mask.count(), 0U);
  EXPECT_NE(nothing.note.find("there is no foreground"), std::string::npos) << nothing.note;
  ForegroundOptions official;
  official.all_when_none = true;
  EXPECT_EQ(foreground_from(probability, "test", official).mask.count(), 1000U);
  probability(99, 9) = 1.0F;  // exactly 5 %
  EXPECT_EQ(foreground_from(probability, "test").mask.count(), 50U);
}

TEST(Foreground, TakesUsersMask) {
  ImageRgb picture(4, 2);
  picture(1, 1) = {255, 255, 255};
  picture(2, 1) = {127, 127, 127};
  const Foreground given = foreground_from_picture(picture, {4, 2}, "mask.png");
  EXPECT_EQ(given.mask.count(), 1U);
  EXPECT_EQ(given.mask(1, 1), 1);
  EXPECT_THROW(foreground_from_picture(picture, {4, 3}, "mask.png"), Error);
}

// An erosion by 17x17 (9x9 twice) takes 8 pixels off each side, but none at the picture's border.
TEST(PromptPoints, GridOfHundredWhereTenFit) {
  const ForegroundMask all({832, 480}, 1);
  EXPECT_EQ(prompt_points(all), grid(0, 800, 0, 400, 100));
  EXPECT_EQ(prompt_points(all).size(), 45U);
}

TEST(PromptPoints, StepShrinksUntilThereAreTen) {
  // x 208..391, y 108..291 remain. Steps 100, 90 and 80 give 4 points at most; 70 (x 210, 280, 350; y 140, 210, 280),
  // 60 and 50 give 9; 40 gives x 240..360, y 120..280.
  const std::vector<PixelIndex> points = prompt_points(rectangle({832, 480}, 200, 100, 400, 300));
  EXPECT_EQ(points, grid(240, 360, 120, 280, 40)) << points.size();
}

TEST(PromptPoints, StopsAtStepTen) {
  // x 48..52, y 48..52 remain: one point at step 10 (and 50).
  const std::vector<PixelIndex> points = prompt_points(rectangle({100, 100}, 40, 40, 61, 61));
  EXPECT_EQ(points, (std::vector<PixelIndex>{{50, 50}}));
  EXPECT_TRUE(prompt_points(rectangle({100, 100}, 40, 40, 50, 50)).empty());
  EXPECT_TRUE(prompt_points(ForegroundMask(1, 1)).empty());
  EXPECT_EQ(prompt_points(ForegroundMask({1, 1}, 1)), (std::vector<PixelIndex>{{0, 0}}));
  EXPECT_TRUE(prompt_points(ForegroundMask()).empty());
}

TEST(Unite, IsTheUnion) {
  const std::vector<ForegroundMask> masks{rectangle({8, 8}, 0, 0, 4, 4), rectangle({8, 8}, 2, 2, 6, 6)};
  EXPECT_EQ(unite(masks).count(), 16U + 16U - 4U);
  EXPECT_THROW(unite({}), std::invalid_argument);
}

TEST(CloseGaps, ClosesAndKeepsOnePixelMore) {
  ForegroundMask mask = rectangle({60, 60}, 20, 20, 40, 40);
  for (int y = 20; y < 40; ++y) mask(30, y) = 0;  // a cut
  EXPECT_EQ(close_gaps(mask), rectangle({60, 60}, 19, 19, 41, 41));
  EXPECT_EQ(close_gaps(ForegroundMask(5, 5)).count(), 0U);
}

}  // namespace
}  // namespace uwv
