// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/depth_composite.h"

#include <gtest/gtest.h>

#include <random>

#include "support/matchers.h"

namespace uwv::testing {
namespace {

ForegroundMask square_mask(Size size, int from, int to) {
  ForegroundMask mask(size);
  for (int y = from; y < to; ++y)
    for (int x = from; x < to; ++x) mask(x, y) = 1;
  return mask;
}

TEST(DepthComposite, hard_edges_take_one_or_the_other) {
  const Size size{50, 50};
  DepthMap near(size, 2.0F);
  near(25, 25) = 0;
  const ForegroundMask mask = square_mask(size, 20, 30);
  const DepthMap out = composite_depth(near, DepthMap(size, 5.0F), mask);
  for (int y = 0; y < 50; ++y)
    for (int x = 0; x < 50; ++x) EXPECT_EQ(out(x, y), x == 25 && y == 25 ? 0.0F : mask(x, y) != 0 ? 2.0F : 5.0F);
}

TEST(DepthComposite, ring_of_twelve_pixels_is_invalid) {
  const Size size{50, 50};
  CompositeOptions options;
  options.ring = true;
  const DepthMap out = composite_depth(DepthMap(size, 2.0F), DepthMap(size, 5.0F), square_mask(size, 20, 30), options);
  for (int x = 0; x < 50; ++x) EXPECT_EQ(out(x, 25), x >= 20 && x < 30 ? 2.0F : x >= 8 && x < 42 ? 0.0F : 5.0F) << x;
  EXPECT_EQ(out(8, 8), 0.0F);
  EXPECT_EQ(out(7, 7), 5.0F);
}

TEST(DepthComposite, closing_fills_gaps_and_keeps_outlines) {
  const Size size{60, 60};
  const ForegroundMask whole = square_mask(size, 10, 50);
  ForegroundMask torn = whole;
  for (int y = 10; y < 50; ++y)
    for (int x = 27; x < 35; ++x) torn(x, y) = 0;  // 8 pixels: two times the reach of 4
  EXPECT_MASK_AGREES(close_mask(torn, 3, 4), whole, 1);
  for (int y = 10; y < 50; ++y) torn(35, y) = 0;
  EXPECT_MASK_AGREES(close_mask(torn, 3, 4), torn, 1);
  CompositeOptions options;
  options.close_iterations = 5;
  const DepthMap out = composite_depth(DepthMap(size, 2.0F), DepthMap(size, 5.0F), torn, options);
  EXPECT_EQ(out(31, 30), 2.0F);
}

TEST(DepthComposite, closing_grows_and_repeats_to_itself) {
  ForegroundMask mask(41, 37);
  std::mt19937 random(2);
  for (auto& m : mask.pixels()) m = random() % 5 == 0;
  const ForegroundMask closed = close_mask(mask, 3, 1);
  for (std::size_t p = 0; p < mask.pixels().size(); ++p) EXPECT_GE(closed.pixels()[p], mask.pixels()[p]);
  EXPECT_MASK_AGREES(close_mask(closed, 3, 1), closed, 1);
}

TEST(DepthComposite, borders_neither_grow_nor_shrink_masks) {
  const ForegroundMask full(9, 7, std::uint8_t{1}), none(9, 7);
  EXPECT_MASK_AGREES(erode_mask(full, 5, 2), full, 1);
  EXPECT_MASK_AGREES(dilate_mask(none, 9, 3), none, 1);
  EXPECT_MASK_AGREES(close_mask(full, 9, 3), full, 1);
}

TEST(DepthComposite, tiny_empty_and_wrong_sizes) {
  CompositeOptions options;
  options.ring = true;
  options.close_iterations = 4;
  EXPECT_TRUE(composite_depth({}, {}, {}, options).empty());
  EXPECT_EQ(
      composite_depth(DepthMap(1, 1, 2.0F), DepthMap(1, 1, 5.0F), ForegroundMask(1, 1, std::uint8_t{1}), options)(0, 0),
      2.0F);
  EXPECT_THROW(composite_depth(DepthMap(2, 1), DepthMap(1, 2), ForegroundMask(2, 1)), std::invalid_argument);
  options.ring_window = 4;
  EXPECT_THROW(options.check(), std::invalid_argument);
  EXPECT_THROW(dilate_mask(ForegroundMask(2, 2), 2, 1), std::invalid_argument);
}

}  // namespace
}  // namespace uwv::testing
