// SPDX-License-Identifier: Apache-2.0
#include "uwv/core/mask.h"

#include <gtest/gtest.h>

#include <type_traits>

namespace uwv {
namespace {

ValidityMask checkerboard(Size size) {
  ValidityMask mask(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) mask(x, y) = static_cast<std::uint8_t>((x + y) % 2);
  return mask;
}

TEST(Mask, ConversionFlipsEveryPixel) {
  const ValidityMask known = checkerboard({5, 3});
  const GenerateMask generate = to_generate(known);
  ASSERT_EQ(generate.size(), known.size());
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 5; ++x) EXPECT_EQ(generate(x, y), 1 - known(x, y)) << x << ", " << y;
  EXPECT_EQ(known.count() + generate.count(), 15U);
}

TEST(Mask, ThereAndBackIsTheSame) {
  const ValidityMask known = checkerboard({7, 4});
  EXPECT_EQ(to_validity(to_generate(known)), known);
  EXPECT_TRUE(to_generate(ValidityMask{}).empty());
}

TEST(Mask, AnyNonZeroByteMeansOne) {
  ValidityMask known(2, 1);
  known(0, 0) = 255;
  EXPECT_EQ(known.count(), 1U);
  EXPECT_EQ(to_generate(known)(0, 0), 0);
  EXPECT_EQ(to_generate(known)(1, 0), 1);
}

TEST(Mask, IntersectKeepsWhatBothKnow) {
  ValidityMask a(4, 1), b(4, 1);
  a(0, 0) = a(1, 0) = 1;
  b(1, 0) = b(2, 0) = 1;
  intersect(a, b);
  ValidityMask both(4, 1);
  both(1, 0) = 1;
  EXPECT_EQ(a, both);
  EXPECT_THROW(intersect(a, ValidityMask(1, 4)), std::invalid_argument);
  EXPECT_EQ(a, both) << "a refused intersection changes nothing";
}

// The compile/ folder beside this file has the same promise as source text.
TEST(Mask, PolaritiesDoNotMix) {
  EXPECT_FALSE((std::is_convertible_v<ValidityMask, GenerateMask>));
  EXPECT_FALSE((std::is_constructible_v<GenerateMask, ValidityMask>));
  EXPECT_FALSE((std::is_assignable_v<ValidityMask&, GenerateMask>));
  EXPECT_FALSE((std::is_convertible_v<Image<std::uint8_t>, ValidityMask>)) << "bytes become a mask only explicitly";
  EXPECT_TRUE((std::is_constructible_v<ValidityMask, Image<std::uint8_t>>));
}

}  // namespace
}  // namespace uwv
