// SPDX-License-Identifier: Apache-2.0
// The matchers themselves must be able to fail, and must name the worst place.
#include "support/matchers.h"

#include <gmock/gmock.h>

#include <limits>

namespace uwv::testing {
namespace {

using ::testing::HasSubstr;

TEST(Matchers, DepthNamesTheWorstPixel) {
  const DepthMap expected({4, 3}, 2.0F);
  DepthMap actual = expected;
  actual(1, 2) = 2.02F;
  actual(3, 0) = 2.5F;
  EXPECT_TRUE(depth_near(actual, expected, 0.3));
  const ::testing::AssertionResult result = depth_near(actual, expected, 1e-3);
  EXPECT_FALSE(result);
  EXPECT_THAT(result.message(), HasSubstr("2 of 12 depths"));
  EXPECT_THAT(result.message(), HasSubstr("(3, 0)"));
}

TEST(Matchers, InvalidDepthMeetsOnlyInvalidDepth) {
  DepthMap expected({2, 1}, 1.0F);
  expected(0, 0) = 0;
  DepthMap actual = expected;
  EXPECT_TRUE(depth_near(actual, expected, 0));
  actual(0, 0) = 1e-9F;
  EXPECT_FALSE(depth_near(actual, expected, 0.5));
  EXPECT_FALSE(depth_near(expected, actual, 0.5));
  actual(0, 0) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(depth_near(actual, expected, 0.5));
}

TEST(Matchers, ImagesMasksAndPosesFailToo) {
  const ImageRgb picture({3, 3}, Rgb8{10, 20, 30});
  ImageRgb other = picture;
  other(2, 1) = {10, 25, 30};
  EXPECT_TRUE(image_near(other, picture, 5));
  EXPECT_THAT(image_near(other, picture, 4).message(), HasSubstr("(2, 1): (10, 25, 30)"));
  EXPECT_FALSE(image_near(ImageRgb(3, 2), picture, 255));

  const ValidityMask mask({2, 2}, 1);
  ValidityMask holed = mask;
  holed(0, 1) = 0;
  EXPECT_TRUE(mask_agrees(holed, mask, 0.75));
  EXPECT_THAT(mask_agrees(holed, mask, 0.76).message(), HasSubstr("(0, 1): 0, expected 1"));

  Rigid3 pose;
  pose.translation.x() = 1e-3;
  EXPECT_TRUE(rigid_near(pose, Rigid3{}, 2e-3));
  EXPECT_FALSE(rigid_near(pose, Rigid3{}, 5e-4));
}

}  // namespace
}  // namespace uwv::testing
