// SPDX-License-Identifier: Apache-2.0
#include "geometry/layers/view_sightings.h"

#include <gtest/gtest.h>

#include <limits>

#include "geometry/layers/smooth_fill.h"

namespace uwv::testing {
namespace {

float agreed(std::vector<float> inverse_depths) { return layers::agreed_surface(inverse_depths, 0.05); }

TEST(AgreedSurface, IsTheNearestThatTwoViewsSee) {
  EXPECT_EQ(agreed({}), 0);
  EXPECT_EQ(agreed({0.5F}), 0.5F);
  EXPECT_NEAR(agreed({0.25F, 0.26F, 0.5F, 0.51F}), 0.505, 0.006);
  EXPECT_NEAR(agreed({0.25F, 0.251F, 0.252F, 0.9F}), 0.251, 0.002);
  // One in nine is chance, though two agree.
  EXPECT_NEAR(agreed({0.25F, 0.251F, 0.252F, 0.253F, 0.254F, 0.25F, 0.25F, 0.9F, 0.9F}), 0.252, 0.003);
}

/// Inverse depth falls off evenly to the right and grows downwards.
float plane(int x, int y) { return 1 / (0.5F - 0.002F * static_cast<float>(x) + 0.003F * static_cast<float>(y)); }

TEST(SmoothFill, ContinuesAPlaneIntoAHoleAtAnyScale) {
  for (const float unit : {1e-6F, 1.0F, 1e9F}) {
    DepthMap depth(120, 80);
    cv::Mat missing = cv::Mat::zeros(80, 120, CV_8U);
    for (int y = 0; y < 80; ++y)
      for (int x = 0; x < 120; ++x) depth(x, y) = unit * plane(x, y);
    missing(cv::Rect(30, 20, 60, 40)).setTo(255);
    for (int y = 20; y < 60; ++y)
      for (int x = 30; x < 90; ++x) depth(x, y) = std::numeric_limits<float>::quiet_NaN();
    layers::fill_smoothly(depth, missing);
    for (int y = 0; y < 80; ++y)
      for (int x = 0; x < 120; ++x) ASSERT_NEAR(depth(x, y) / (unit * plane(x, y)), 1, 0.01) << x << ' ' << y;
  }
}

TEST(SmoothFill, StaysBetweenWhatIsAroundAndLeavesTheRestAlone) {
  DepthMap depth(40, 40, 3.0F);
  for (int y = 0; y < 40; ++y) depth(0, y) = 1.0F;
  depth(5, 5) = 0;  // unknown, but not asked for
  cv::Mat missing = cv::Mat::zeros(40, 40, CV_8U);
  missing(cv::Rect(1, 10, 20, 30)).setTo(255);
  layers::fill_smoothly(depth, missing);
  EXPECT_EQ(depth(5, 5), 0);
  EXPECT_EQ(depth(30, 30), 3.0F);
  for (int y = 10; y < 40; ++y)
    for (int x = 1; x < 21; ++x) {
      ASSERT_GE(depth(x, y), 0.98F);
      ASSERT_LE(depth(x, y), 3.06F);
    }
}

TEST(SmoothFill, WithNothingKnownThereIsNothing) {
  DepthMap depth(33, 9, 0.0F);
  layers::fill_smoothly(depth, cv::Mat(9, 33, CV_8U, cv::Scalar(255)));
  for (const float z : depth.pixels()) EXPECT_EQ(z, 0);
  DepthMap dot(1, 1, 4.0F);
  layers::fill_smoothly(dot, cv::Mat(1, 1, CV_8U, cv::Scalar(255)));
  EXPECT_EQ(dot(0, 0), 0);
}

}  // namespace
}  // namespace uwv::testing
