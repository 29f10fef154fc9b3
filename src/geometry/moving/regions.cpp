// SPDX-License-Identifier: Apache-2.0
#include "geometry/moving/regions.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace uwv::moving {
namespace {

/// Sets the pixels of the 8-connected pieces of `picture` for which keep(label) is false to 0. Returns how many stay.
template <class Keep>
int keep_pieces(cv::Mat& picture, const cv::Mat& labels, int pieces, const Keep& keep) {
  std::vector<char> kept(static_cast<std::size_t>(pieces), 0);
  int count = 0;
  for (int i = 1; i < pieces; ++i) {
    kept[static_cast<std::size_t>(i)] = keep(i) ? 1 : 0;
    count += kept[static_cast<std::size_t>(i)];
  }
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x)
      if (kept[static_cast<std::size_t>(labels.at<int>(y, x))] == 0) picture.at<std::uint8_t>(y, x) = 0;
  return count;
}

}  // namespace

cv::Mat hysteresis(const cv::Mat& score, double high, double low) {
  cv::Mat candidates = score >= low;
  cv::Mat labels;
  const int pieces = cv::connectedComponents(candidates, labels, 8, CV_32S);
  std::vector<char> seeded(static_cast<std::size_t>(pieces), 0);
  for (int y = 0; y < score.rows; ++y)
    for (int x = 0; x < score.cols; ++x)
      if (score.at<float>(y, x) >= static_cast<float>(high)) seeded[static_cast<std::size_t>(labels.at<int>(y, x))] = 1;
  keep_pieces(candidates, labels, pieces, [&](int i) { return seeded[static_cast<std::size_t>(i)] != 0; });
  return candidates;
}

int tidy_regions(cv::Mat& regions, double smallest, double hole) {
  // Outlines that flow could not judge leave notches of this size.
  const int side = 1 + 2 * std::max(1, regions.rows / 48);
  const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(side, side));
  cv::morphologyEx(regions, regions, cv::MORPH_CLOSE, disc);
  cv::Mat outside = regions == 0;
  cv::Mat labels, stats, centres;
  const auto area = [&](int i) { return static_cast<double>(stats.at<int>(i, cv::CC_STAT_AREA)); };
  int pieces = cv::connectedComponentsWithStats(outside, labels, stats, centres, 4, CV_32S);
  keep_pieces(outside, labels, pieces, [&](int i) { return area(i) >= hole; });
  regions = outside == 0;
  pieces = cv::connectedComponentsWithStats(regions, labels, stats, centres, 8, CV_32S);
  return keep_pieces(regions, labels, pieces, [&](int i) { return area(i) >= smallest; });
}

void grow_to_outlines(cv::Mat& regions, const cv::Mat& picture) {
  if (cv::countNonZero(regions) == 0) return;
  const int side = 1 + 2 * std::max(1, regions.rows / 40);
  const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(side, side));
  cv::Mat around;
  cv::dilate(regions, around, disc);
  cv::Mat markers = cv::Mat::zeros(regions.size(), CV_32S);
  markers.setTo(1, around == 0);
  markers.setTo(2, regions);
  cv::watershed(picture, markers);
  // Watershed leaves the picture's rim unlabelled.
  const cv::Mat grown = markers == 2;
  regions |= grown;
}

ValidityMask static_from_regions(const cv::Mat& regions, Size size) {
  cv::Mat large;
  if (regions.cols == size.width && regions.rows == size.height)
    large = regions;
  else
    cv::resize(regions, large, cv::Size(size.width, size.height), 0, 0, cv::INTER_LINEAR);
  ValidityMask mask(size, std::uint8_t{1});
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      if (large.at<std::uint8_t>(y, x) >= 128) mask(x, y) = 0;
  return mask;
}

}  // namespace uwv::moving
