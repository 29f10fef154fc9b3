// SPDX-License-Identifier: Apache-2.0
#include "uwv/core/image.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace uwv {
namespace {

TEST(Image, DefaultIsEmpty) {
  const ImageRgb image;
  EXPECT_TRUE(image.empty());
  EXPECT_EQ(image.size(), Size{});
  EXPECT_TRUE(image.pixels().empty());
  EXPECT_FALSE(image.contains(0, 0));
}

TEST(Image, StartsFilled) {
  const Image<int> image(3, 2, 7);
  EXPECT_EQ(std::count(image.pixels().begin(), image.pixels().end(), 7), 6);
  EXPECT_EQ(ImageRgb(1, 1)(0, 0), Rgb8{});
}

TEST(Image, RowsFollowEachOtherWithoutGaps) {
  Image<int> image(5, 4);
  int next = 0;
  for (int& pixel : image.pixels()) pixel = next++;
  for (int y = 0; y < 4; ++y) {
    EXPECT_EQ(image.row(y), image.data() + y * 5);
    for (int x = 0; x < 5; ++x) EXPECT_EQ(image(x, y), y * 5 + x);
  }
  EXPECT_EQ(sizeof(Rgb8), 3U) << "colour pictures are read as bytes";
}

TEST(Image, DataIsCacheAligned) {
  for (int width = 1; width < 40; ++width) {
    const Image<std::uint8_t> bytes(width, 3);
    const ImageRgb colours(width, 3);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(bytes.data()) % 64, 0U) << width;
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(colours.data()) % 64, 0U) << width;
  }
}

TEST(Image, CopyIsIndependent) {
  Image<int> a(2, 2, 1);
  Image<int> b = a;
  EXPECT_EQ(a, b);
  b(1, 1) = 5;
  EXPECT_NE(a, b);
  EXPECT_EQ(a(1, 1), 1);
}

TEST(Image, MoveKeepsThePixelsInPlace) {
  Image<int> a(2, 2, 1);
  const int* before = a.data();
  const Image<int> b = std::move(a);
  EXPECT_EQ(b.data(), before);
}

TEST(Image, SameCountOfPixelsButOtherShapeIsNotEqual) { EXPECT_NE(Image<int>(2, 3), Image<int>(3, 2)); }

TEST(Image, ContainsIsHalfOpen) {
  const Image<int> image(3, 2);
  EXPECT_TRUE(image.contains(0, 0));
  EXPECT_TRUE(image.contains(2, 1));
  EXPECT_FALSE(image.contains(3, 1));
  EXPECT_FALSE(image.contains(2, 2));
  EXPECT_FALSE(image.contains(-1, 0));
  EXPECT_FALSE(image.contains(0, -1));
}

TEST(Image, ResizeToTheSameSizeKeepsPixels) {
  Image<int> image(3, 2, 7);
  image.resize({3, 2});
  EXPECT_EQ(image, Image<int>(3, 2, 7));
  image.resize({5, 4});
  EXPECT_EQ(image.size(), (Size{5, 4}));
  EXPECT_EQ(image.pixels().size(), 20U);
  image.fill(9);
  EXPECT_EQ(image, Image<int>(5, 4, 9));
}

TEST(Image, NegativeSizeIsRefusedAndChangesNothing) {
  EXPECT_THROW(Image<int>(-1, 2), std::invalid_argument);
  EXPECT_THROW(Image<int>(2, -1), std::invalid_argument);
  Image<int> image(3, 2, 7);
  EXPECT_THROW(image.resize({3, -2}), std::invalid_argument);
  EXPECT_EQ(image, Image<int>(3, 2, 7));
}

TEST(Size, CountsPixelsBeyondIntRange) { EXPECT_EQ((Size{65535, 65535}.pixels()), std::size_t{65535} * 65535); }

}  // namespace
}  // namespace uwv
