// SPDX-License-Identifier: Apache-2.0
#include "model/vae/tiny_vae_cost.h"

#include <gtest/gtest.h>

namespace uwv::model {
namespace {

// Counted layer by layer for one latent of 2 channels, levels of 3, 2 and 1 channels, 1 at full size: products of each
// convolution are pixels * 9 * channels in * channels out, and each counts as two operations.
TEST(TinyVaeCost, OperationsAreThoseCountedByHand) {
  const TinyVaeSizes sizes{2, {3, 2, 1}, 1};
  const double first_level = 18 * 2 * 3        // the latents' convolution
                             + 9 * 18 * 3 * 3  // three blocks of three convolutions, with no frame before
                             + 2 * 3 * 3       // one frame made of one
                             + 4 * 18 * 3 * 2;
  const double second_level = 4 * (9 * 18 * 2 * 2 + 2 * 2 * 4) + 2 * 16 * 18 * 2 * 1;
  const double third_level = 16 * (9 * 18 + 12 * 18 + 2 * 2 * 2) + 4 * 64 * 18;  // two frames, the first alone
  const double colours = 4 * 64 * 18 * 3;
  const double one = first_level + second_level + third_level + colours;
  EXPECT_EQ(estimated_flops(sizes, {1, 8, 8}), one);
  // Later latents' frames all have one before them: three convolutions more in each level.
  const double before = 3 * 18 * (1 * 9 + 4 * 4 + 16 * 1);
  EXPECT_EQ(estimated_flops(sizes, {9, 8, 8}), 3 * one + 2 * before);
  EXPECT_EQ(estimated_flops(sizes, {9, 16, 24}), 6 * (3 * one + 2 * before));
}

TEST(TinyVaeCost, WidthsAreReadFromTheFile) {
  const TinyVaeSizes sizes = TinyVaeSizes::read(UWV_TEST_DATA "/taehv");
  EXPECT_EQ(sizes.z_dim, 16);
  EXPECT_EQ(sizes.levels, (std::array<std::int64_t, 3>{12, 8, 6}));
  EXPECT_EQ(sizes.last, 4);
}

TEST(TinyVaeCost, MemoryGrowsWithThePictureNotWithTheClip) {
  const TinyVaeSizes sizes;
  const double one = estimated_working_bytes(sizes, {5, 240, 416}, VaePrecision::f32);
  EXPECT_EQ(estimated_working_bytes(sizes, {81, 240, 416}, VaePrecision::f32), one);
  EXPECT_EQ(estimated_working_bytes(sizes, {5, 480, 832}, VaePrecision::f32), 4 * one);
  EXPECT_EQ(estimated_working_bytes(sizes, {5, 240, 416}, VaePrecision::bf16), one / 2);
  EXPECT_EQ(estimated_weight_bytes(sizes, VaePrecision::bf16), estimated_weight_bytes(sizes, VaePrecision::f32) / 2);
}

}  // namespace
}  // namespace uwv::model
