// SPDX-License-Identifier: Apache-2.0
#include "geometry/layers/colour_model.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

namespace uwv::layers {
namespace {

constexpr int levels = 16;
constexpr std::size_t bins = levels * levels * levels;

std::size_t bin_of(const cv::Vec3b& c) {
  return static_cast<std::size_t>(((c[0] >> 4) * levels + (c[1] >> 4)) * levels + (c[2] >> 4));
}

/// Neighbouring levels share: (1 2 1) / 4 along each channel.
void smooth(std::vector<float>& histogram) {
  std::vector<float> before;
  for (const std::size_t step : {std::size_t{1}, std::size_t{levels}, std::size_t{levels} * levels}) {
    before = histogram;
    for (std::size_t i = 0; i < bins; ++i) {
      const std::size_t level = i / step % levels;
      const float low = before[level > 0 ? i - step : i], high = before[level + 1 < levels ? i + step : i];
      histogram[i] = 0.25F * low + 0.5F * before[i] + 0.25F * high;
    }
  }
}

void take_in(std::vector<float> now, double rate, std::vector<float>& model) {
  float total = 0;
  for (const float v : now) total += v;
  if (!(total > 0)) return;
  smooth(now);
  const auto share = static_cast<float>(rate);
  for (std::size_t i = 0; i < bins; ++i) model[i] = (1 - share) * model[i] + share * now[i] / total;
}

}  // namespace

ColourModel::ColourModel() : foreground_(bins), surroundings_(bins), odds_(bins) {}

void ColourModel::learn(const cv::Mat& picture, const cv::Mat& mask, int reach, double rate) {
  cv::Mat near;
  const int side = 2 * reach + 1;
  cv::dilate(mask, near, cv::getStructuringElement(cv::MORPH_RECT, {side, side}));
  std::vector<float> inside(bins), outside(bins);
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x) {
      if (near.at<std::uint8_t>(y, x) == 0) continue;
      (mask.at<std::uint8_t>(y, x) != 0 ? inside : outside)[bin_of(picture.at<cv::Vec3b>(y, x))] += 1;
    }
  take_in(std::move(inside), rate, foreground_);
  take_in(std::move(outside), rate, surroundings_);
  // A share of 1/4000 is what chance gives a bin: rarer colours say little.
  constexpr float chance = 2.5e-4F;
  for (std::size_t i = 0; i < bins; ++i)
    odds_[i] = std::clamp(std::log((foreground_[i] + chance) / (surroundings_[i] + chance)), -3.0F, 3.0F);
}

float ColourModel::log_odds(const cv::Vec3b& colour) const { return odds_[bin_of(colour)]; }

}  // namespace uwv::layers
