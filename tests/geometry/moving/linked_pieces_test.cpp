// SPDX-License-Identifier: Apache-2.0
#include "geometry/moving/linked_pieces.h"

#include <gtest/gtest.h>

namespace uwv::testing {
namespace {

constexpr Size picture{120, 80};

void put(Image<std::uint8_t>& mask, int x0, int y0, int x1, int y1, std::uint8_t value) {
  for (int y = std::max(0, y0); y < std::min(mask.height(), y1); ++y)
    for (int x = std::max(0, x0); x < std::min(mask.width(), x1); ++x) mask(x, y) = value;
}

std::vector<ValidityMask> all_static(int frames) {
  return std::vector<ValidityMask>(static_cast<std::size_t>(frames), ValidityMask(picture, std::uint8_t{1}));
}

/// A figure 20 x 40 that stands at (50, 20).
std::vector<ForegroundMask> standing_figure(int frames) {
  std::vector<ForegroundMask> masks(static_cast<std::size_t>(frames), ForegroundMask(picture));
  for (ForegroundMask& mask : masks) put(mask, 50, 20, 70, 60, 1);
  return masks;
}

/// Blue before green.
std::vector<ImageRgb> pictures_of(const std::vector<ForegroundMask>& masks) {
  std::vector<ImageRgb> frames;
  for (const ForegroundMask& mask : masks) {
    ImageRgb& frame = frames.emplace_back(picture, Rgb8{40, 160, 40});
    for (std::size_t p = 0; p < mask.pixels().size(); ++p)
      if (mask.pixels()[p] != 0) frame.pixels()[p] = {40, 40, 200};
  }
  return frames;
}

std::size_t moving_pixels(const ValidityMask& mask) { return picture.pixels() - mask.count(); }

class LinkedPiecesTest : public ::testing::Test {
 protected:
  ThreadPool pool_{2};
};

TEST_F(LinkedPiecesTest, AFigureOfWhichHalfWasFoundMovingIsTakenWhole) {
  const std::vector<ForegroundMask> figure = standing_figure(5);
  std::vector<ValidityMask> masks = all_static(5);
  for (ValidityMask& mask : masks) put(mask, 50, 40, 70, 60, 0);
  moving::adopt_foreground(pictures_of(figure), figure, 0.3, 8, pool_, masks);
  for (std::size_t i = 0; i < 5; ++i)
    for (std::size_t p = 0; p < picture.pixels(); ++p) ASSERT_EQ(masks[i].pixels()[p] == 0, figure[i].pixels()[p] != 0);
}

TEST_F(LinkedPiecesTest, AFigureThatStandsStillStaysStatic) {
  const std::vector<ForegroundMask> figure = standing_figure(5);
  std::vector<ValidityMask> masks = all_static(5);
  for (ValidityMask& mask : masks) put(mask, 50, 52, 70, 60, 0);
  const std::vector<ValidityMask> before = masks;
  moving::adopt_foreground(pictures_of(figure), figure, 0.3, 8, pool_, masks);
  EXPECT_EQ(masks, before);
}

TEST_F(LinkedPiecesTest, APauseInMidStrideDoesNotTearItApartAndALongRestIsStatic) {
  const std::vector<ForegroundMask> figure = standing_figure(60);
  std::vector<ValidityMask> masks = all_static(60);
  for (const std::size_t i : {0, 1, 2, 3, 4, 8, 9, 10, 11, 12}) put(masks[i], 50, 20, 70, 60, 0);
  moving::adopt_foreground(pictures_of(figure), figure, 0.3, 4, pool_, masks);
  for (std::size_t i = 0; i <= 12; ++i) EXPECT_EQ(moving_pixels(masks[i]), figure[i].count()) << "frame " << i;
  for (std::size_t i = 17; i < 60; ++i) EXPECT_EQ(moving_pixels(masks[i]), 0U) << "frame " << i;
}

TEST_F(LinkedPiecesTest, ColourSettlesTheOutlineBeyondTheForeground) {
  // The figure has blue feet that the foreground has lost; flow has blurred motion over the green beside it.
  const std::vector<ForegroundMask> figure = standing_figure(3);
  std::vector<ImageRgb> frames = pictures_of(figure);
  std::vector<ValidityMask> masks = all_static(3);
  for (std::size_t i = 0; i < 3; ++i) {
    for (int y = 60; y < 63; ++y)
      for (int x = 52; x < 60; ++x) frames[i](x, y) = {40, 40, 200};
    put(masks[i], 47, 20, 70, 63, 0);
  }
  moving::adopt_foreground(frames, figure, 0.3, 8, pool_, masks);
  EXPECT_EQ(masks[1](56, 61), 0);
  EXPECT_EQ(masks[1](48, 40), 1);
  EXPECT_EQ(masks[1](66, 61), 1);
}

TEST_F(LinkedPiecesTest, WhatDoesNotLastOrIsTinyGoes) {
  std::vector<ValidityMask> masks = all_static(6);
  for (int i = 0; i < 6; ++i) put(masks[static_cast<std::size_t>(i)], 10 + 3 * i, 10, 20 + 3 * i, 20, 0);
  put(masks[2], 80, 50, 90, 60, 0);  // one frame
  for (int i = 0; i < 6; ++i) put(masks[static_cast<std::size_t>(i)], 5, 70, 7, 72, 0);
  EXPECT_EQ(moving::drop_fleeting(3, 10, pool_, masks), 6);
  for (const ValidityMask& mask : masks) EXPECT_EQ(moving_pixels(mask), 100U);
}

TEST_F(LinkedPiecesTest, ShortClipsKeepWhatIsInAllTheirFrames) {
  for (const int frames : {1, 2}) {
    std::vector<ValidityMask> masks = all_static(frames);
    for (ValidityMask& mask : masks) mask(7, 7) = 0;
    EXPECT_EQ(moving::drop_fleeting(3, 0, pool_, masks), frames);
    EXPECT_EQ(masks[0](7, 7), 0);
  }
}

TEST_F(LinkedPiecesTest, HolesCloseUpToAShareOfThePiece) {
  std::vector<ValidityMask> masks = all_static(1);
  put(masks[0], 10, 10, 50, 50, 0);
  put(masks[0], 20, 20, 26, 26, 1);  // 36 of 1600
  put(masks[0], 30, 12, 48, 48, 1);  // a large one
  put(masks[0], 60, 0, 100, 40, 0);
  put(masks[0], 70, 0, 76, 6, 1);  // open at the border
  moving::close_holes(0.1, pool_, masks);
  EXPECT_EQ(masks[0](22, 22), 0);
  EXPECT_EQ(masks[0](40, 30), 1);
  EXPECT_EQ(masks[0](72, 2), 1);
}

TEST_F(LinkedPiecesTest, PicturesFullOfMotionOrOfOnePixelAreAnswered) {
  std::vector<ValidityMask> full = all_static(3);
  for (ValidityMask& mask : full) mask.fill(0);
  const std::vector<ForegroundMask> everything(3, ForegroundMask(picture, std::uint8_t{1}));
  moving::adopt_foreground(pictures_of(everything), everything, 0.3, 8, pool_, full);
  EXPECT_EQ(moving::drop_fleeting(3, 1, pool_, full), 3);
  moving::close_holes(0.1, pool_, full);
  EXPECT_EQ(full[1].count(), 0U);
  std::vector<ValidityMask> single(3, ValidityMask(1, 1, std::uint8_t{0}));
  const std::vector<ForegroundMask> dot(3, ForegroundMask(1, 1, std::uint8_t{1}));
  moving::adopt_foreground(std::vector<ImageRgb>(3, ImageRgb(1, 1)), dot, 0.3, 8, pool_, single);
  EXPECT_EQ(moving::drop_fleeting(3, 0, pool_, single), 3);
  moving::close_holes(0.1, pool_, single);
  EXPECT_EQ(single[0](0, 0), 0);
}

}  // namespace
}  // namespace uwv::testing
