// SPDX-License-Identifier: Apache-2.0
#include "uwv/eval/image_metrics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace uwv {
namespace {

ImageRgb waves(Size size) {
  ImageRgb picture(size);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const auto value = [&](double k) { return static_cast<std::uint8_t>(127 + 100 * std::sin(k * x + 0.3 * y)); };
      picture(x, y) = {value(0.2), value(0.35), value(0.5)};
    }
  }
  return picture;
}

TEST(ImageMetrics, PsnrOfAConstantDifferenceIsItsLogarithm) {
  const ImageRgb a({5, 4}, Rgb8{100, 100, 100});
  const ImageRgb b({5, 4}, Rgb8{110, 110, 110});
  EXPECT_NEAR(psnr(MetricImage(a), MetricImage(b)), 20 * std::log10(255.0 / 10), 1e-12);
  EXPECT_EQ(psnr(MetricImage(a), MetricImage(a)), HUGE_VAL);
}

TEST(ImageMetrics, MaskedPsnrSeesOnlyWhatTheMaskLeaves) {
  const ImageRgb a = waves({8, 6});
  ImageRgb b = a;
  b(3, 2).g = static_cast<std::uint8_t>(b(3, 2).g + 17);
  ValidityMask only_it({8, 6}, 0);
  only_it(3, 2) = 1;
  ValidityMask all_but_it({8, 6}, 1);
  all_but_it(3, 2) = 0;
  EXPECT_NEAR(mean_squared_error(MetricImage(a), MetricImage(b), &only_it), 17.0 * 17 / (255.0 * 255) / 3, 1e-15);
  EXPECT_EQ(psnr(MetricImage(a), MetricImage(b), &all_but_it), HUGE_VAL);
  const ValidityMask none({8, 6}, 0);
  EXPECT_TRUE(std::isnan(psnr(MetricImage(a), MetricImage(b), &none)));
}

TEST(ImageMetrics, SsimIsOneForEqualPicturesAndSymmetric) {
  const MetricImage a(waves({40, 30}));
  ImageRgb changed = waves({40, 30});
  for (Rgb8& pixel : changed.pixels()) pixel.r = static_cast<std::uint8_t>(255 - pixel.r);
  const MetricImage b(changed);
  EXPECT_NEAR(ssim(a, a), 1.0, 1e-12);
  EXPECT_LT(ssim(a, b), 0.9);
  EXPECT_NEAR(ssim(a, b), ssim(b, a), 1e-12);
}

TEST(ImageMetrics, MaskedSsimIgnoresWhateverLiesOutsideTheMask) {
  const Size size{50, 40};
  const ImageRgb a = waves(size);
  ImageRgb b = a;
  for (Rgb8& pixel : b.pixels()) pixel.b = static_cast<std::uint8_t>(pixel.b / 2);
  ImageRgb c = b;
  ValidityMask mask(size, 1);
  for (int y = 10; y < 14; ++y) {
    for (int x = 20; x < 30; ++x) {
      mask(x, y) = 0;
      c(x, y) = {255, 0, 255};
    }
  }
  EXPECT_NE(ssim(MetricImage(a), MetricImage(b)), ssim(MetricImage(a), MetricImage(c)));
  EXPECT_EQ(ssim(MetricImage(a), MetricImage(b), &mask), ssim(MetricImage(a), MetricImage(c), &mask));
}

TEST(ImageMetrics, MaskedSsimAveragesExactlyThePixelsWithFullWindows) {
  const Size size{30, 26};
  const MetricImage a(waves(size));
  ImageRgb other = waves(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) other(x, y).r = static_cast<std::uint8_t>(other(x, y).r / (1 + x % 3));
  const MetricImage b(other);
  ValidityMask mask(size, 0);
  for (int y = 3; y < 15; ++y)
    for (int x = 7; x < 20; ++x) mask(x, y) = 1;
  // A block of 13x12 holds 3x2 windows of 11x11, centred at x = 12..14 and y = 8..9.
  const std::vector<Image<double>> map = ssim_map(a, b);
  double sum = 0;
  for (const Image<double>& plane : map)
    for (int y = 8; y <= 9; ++y)
      for (int x = 12; x <= 14; ++x) sum += plane(x, y);
  EXPECT_NEAR(ssim(a, b, &mask), sum / 18, 1e-14);
}

TEST(ImageMetrics, SsimOfPicturesSmallerThanItsWindowIsNotANumber) {
  const MetricImage a(waves({10, 40}));
  EXPECT_TRUE(std::isnan(ssim(a, a)));
  const MetricImage one(waves({1, 1}));
  EXPECT_NEAR(ssim_map(one, one)[0](0, 0), 1.0, 1e-12);
}

TEST(ImageMetrics, DifferentShapesAreRefused) {
  const MetricImage a(waves({12, 12}));
  const MetricImage b(waves({12, 13}));
  const ValidityMask mask({3, 3}, 1);
  EXPECT_THROW(psnr(a, b), std::invalid_argument);
  EXPECT_THROW(ssim(a, a.grey()), std::invalid_argument);
  EXPECT_THROW(ssim(a, a, &mask), std::invalid_argument);
  EXPECT_THROW(a.grey().grey(), std::invalid_argument);
  EXPECT_THROW(MetricImage{ImageRgb{}}, std::invalid_argument);
  EXPECT_THROW(MetricImage(Size{2, 2}, 3, std::vector<float>(11)), std::invalid_argument);
}

TEST(ImageMetrics, ValidShareCountsOnes) {
  ValidityMask mask({4, 2}, 0);
  mask(1, 1) = 1;
  EXPECT_EQ(valid_share(mask), 0.125);
  EXPECT_TRUE(std::isnan(valid_share(ValidityMask())));
}

}  // namespace
}  // namespace uwv
