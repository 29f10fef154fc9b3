// SPDX-License-Identifier: Apache-2.0
// The sky of the planar prior, and the evidence for it.
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "geometry/layers/cv_bridge.h"
#include "geometry/layers/prior_parts.h"

namespace uwv::layers {
namespace {

constexpr double least_share = 0.01, least_of_edge = 0.1;  // of the picture, and of its upper edge: not a lamp
constexpr double least_contrast = 1.45;                    // measured: skies 1.6 and more, lit walls 1.3 and less
constexpr double least_contrast_blue = 0.9;                // snow is brighter than the bluest sky

/// Hue and smoothness of a sky, which bluish walls share.
bool looks_like_sky(const cv::Vec3f& c, float rough) {
  const float brightest = std::max({c[0], c[1], c[2]}), darkest = std::min({c[0], c[1], c[2]});
  const bool blue = c[2] > 90 && c[2] >= 1.08F * c[0] && c[2] >= 0.98F * c[1];
  // Overcast is neutral or bluish; white walls in lamp light are warm.
  const bool pale = darkest > 185 && brightest - darkest < 40 && c[2] >= c[0] - 2;
  return (blue && rough < 9) || (pale && rough < 4);
}

/// 1 where the picture has the colour and smoothness of a sky.
Image<std::uint8_t> candidates(const ImageRgb& picture, const ForegroundMask& foreground) {
  Image<std::uint8_t> out(picture.size());
  cv::Mat colour;
  view(picture).convertTo(colour, CV_32F);
  const cv::Mat rough = roughness(colour);
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      const bool covered = !foreground.empty() && foreground(x, y) != 0;
      out(x, y) = !covered && looks_like_sky(colour.at<cv::Vec3f>(y, x), rough.at<float>(y, x));
    }
  return out;
}

/// Keeps what touches the upper edge.
void keep_top(cv::Mat& mask) {
  cv::Mat labels;
  const int count = cv::connectedComponents(mask, labels, 4);
  std::vector<std::uint8_t> at_top(static_cast<std::size_t>(count), 0);
  for (int x = 0; x < labels.cols; ++x) at_top[static_cast<std::size_t>(labels.at<int>(0, x))] = 1;
  at_top[0] = 0;
  for (int y = 0; y < labels.rows; ++y)
    for (int x = 0; x < labels.cols; ++x)
      mask.at<std::uint8_t>(y, x) = at_top[static_cast<std::size_t>(labels.at<int>(y, x))];
}

/// Clouds' outlines leave gaps, which would stand before the sky like a fence; what does not reach the
/// lower edge hangs in the sky and is sky.
void fill_gaps(cv::Mat& mask, double diameter) {
  const int side = std::max(1, cvRound(diameter)) | 1;
  const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side});
  cv::Mat closed;
  cv::morphologyEx(mask, closed, cv::MORPH_CLOSE, disc);
  cv::Mat outside = closed == 0, labels;
  const int count = cv::connectedComponents(outside, labels, 4);
  std::vector<std::uint8_t> open(static_cast<std::size_t>(count), 0);
  const int last = labels.rows - 1;
  for (int x = 0; x < labels.cols; ++x) open[static_cast<std::size_t>(labels.at<int>(last, x))] = 1;
  for (int y = 0; y < labels.rows; ++y)
    for (int x = 0; x < labels.cols; ++x) {
      const auto label = static_cast<std::size_t>(labels.at<int>(y, x));
      mask.at<std::uint8_t>(y, x) = label == 0 || open[label] == 0;
    }
}

double median_of(std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

SkyEvidence judge(const ImageRgb& picture, const cv::Mat& mask) {
  std::vector<double> inside, outside, hue;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      const Rgb8 c = picture(x, y);
      const bool in = mask.at<std::uint8_t>(y, x) != 0;
      (in ? inside : outside).push_back(0.299 * c.r + 0.587 * c.g + 0.114 * c.b);
      if (in) hue.push_back(c.b / std::max(1.0, static_cast<double>(c.r)));
    }
  SkyEvidence out;
  out.share = static_cast<double>(inside.size()) / static_cast<double>(picture.size().pixels());
  out.of_edge = static_cast<double>(cv::countNonZero(mask.row(0))) / picture.width();
  // Without anything else in the picture there is nothing to be brighter than.
  out.contrast = outside.empty() ? 0 : median_of(inside) / std::max(1.0, median_of(outside));
  out.blue_over_red = median_of(hue);
  const bool enough = out.share >= least_share && out.of_edge >= least_of_edge;
  const bool clear_blue = out.blue_over_red >= 1.4 && out.of_edge >= 0.5 && out.contrast >= least_contrast_blue;
  out.believed = enough && (clear_blue || out.contrast >= least_contrast);
  return out;
}

}  // namespace

Image<std::uint8_t> find_sky(const ImageRgb& picture, const ForegroundMask& foreground, SkyEvidence& evidence) {
  Image<std::uint8_t> sky = candidates(picture, foreground);
  cv::Mat mask = view(sky);
  keep_top(mask);
  evidence = judge(picture, mask);
  if (evidence.believed)
    fill_gaps(mask, 0.03 * picture.height());
  else
    sky.fill(0);
  return sky;
}

std::optional<double> horizon_from_sky(const Image<std::uint8_t>& sky) {
  std::vector<int> ends;
  for (int x = 0; x < sky.width(); ++x) {
    int y = 0;
    while (y < sky.height() && sky(x, y) != 0) ++y;
    if (y > 0) ends.push_back(y);
  }
  if (static_cast<int>(ends.size()) < 0.7 * sky.width()) return std::nullopt;
  std::sort(ends.begin(), ends.end());
  const int low = ends[ends.size() / 5], middle = ends[ends.size() / 2], high = ends[ends.size() * 4 / 5];
  const int height = sky.height();
  if (high - low > 0.06 * height || middle < 0.15 * height || middle > 0.75 * height) return std::nullopt;
  return middle;
}

}  // namespace uwv::layers
