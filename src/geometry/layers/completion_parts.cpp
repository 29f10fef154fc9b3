// SPDX-License-Identifier: Apache-2.0
#include "geometry/layers/completion_parts.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/photo.hpp>
#include <opencv2/video/tracking.hpp>

#include "geometry/layers/cv_bridge.h"

namespace uwv::layers {
namespace {

constexpr int fewest_corners = 12;

/// Corners of `from` and where they are in `to`, those whose way back leads home.
void track_corners(const SeenFrame& from, const SeenFrame& to, std::vector<cv::Point2f>& a,
                   std::vector<cv::Point2f>& b) {
  cv::Mat grey_from, grey_to;
  cv::cvtColor(from.picture, grey_from, cv::COLOR_RGB2GRAY);
  cv::cvtColor(to.picture, grey_to, cv::COLOR_RGB2GRAY);
  std::vector<cv::Point2f> corners, there, back;
  cv::goodFeaturesToTrack(grey_from, corners, 500, 0.01, 7, from.background);
  if (corners.size() < fewest_corners) return;
  std::vector<std::uint8_t> forward_ok, back_ok;
  cv::calcOpticalFlowPyrLK(grey_from, grey_to, corners, there, forward_ok, {});
  cv::calcOpticalFlowPyrLK(grey_to, grey_from, there, back, back_ok, {});
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const cv::Point2f miss = back[i] - corners[i];
    if (forward_ok[i] == 0 || back_ok[i] == 0 || std::hypot(miss.x, miss.y) > 0.5F) continue;
    a.push_back(corners[i]);
    b.push_back(there[i]);
  }
}

}  // namespace

void invent(cv::Mat& picture, const cv::Mat& missing, const CompletionOptions& options) {
  const int holes = cv::countNonZero(missing);
  if (holes == 0) return;
  if (holes == missing.rows * missing.cols) {
    picture.setTo(cv::Scalar(128, 128, 128));
    return;
  }
  const double scale = std::min(1.0, options.inpaint_side / static_cast<double>(std::max(picture.cols, picture.rows)));
  const cv::Size size(std::max(1, cvRound(picture.cols * scale)), std::max(1, cvRound(picture.rows * scale)));
  cv::Mat known, weight, small, small_missing, filled;
  // Foreground colours must not bleed into the shrunk picture: each pixel is the mean of what is known of it.
  picture.convertTo(known, CV_32F);
  known.setTo(cv::Scalar::all(0), missing);
  cv::Mat is_known = missing == 0;
  is_known.convertTo(weight, CV_32F, 1.0 / 255);
  cv::resize(known, known, size, 0, 0, cv::INTER_AREA);
  cv::resize(weight, weight, size, 0, 0, cv::INTER_AREA);
  small_missing = weight < 0.25;
  cv::Mat weights;
  cv::merge(std::vector<cv::Mat>(3, cv::max(weight, 1e-3)), weights);
  cv::Mat mean = known / weights;
  mean.convertTo(small, CV_8U);
  if (std::min(size.width, size.height) > 2 && cv::countNonZero(small_missing) < size.area())
    cv::inpaint(small, small_missing, filled, options.inpaint_radius, cv::INPAINT_TELEA);
  else
    filled = small;
  cv::resize(filled, filled, picture.size(), 0, 0, cv::INTER_LINEAR);
  filled.copyTo(picture, missing);
}

std::array<float, 3> exposure_gain(const SeenFrame& own, const cv::Mat& other, const cv::Mat& other_background) {
  const cv::Mat shared = own.background & other_background;
  if (cv::countNonZero(shared) < 50) return {1, 1, 1};
  const cv::Scalar here = cv::mean(own.picture, shared), there = cv::mean(other, shared);
  std::array<float, 3> gain{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double ratio = (here[static_cast<int>(c)] + 1) / (there[static_cast<int>(c)] + 1);
    gain[c] = static_cast<float>(std::clamp(ratio, 0.5, 2.0));
  }
  return gain;
}

bool background_homography(const SeenFrame& from, const SeenFrame& to, cv::Mat& to_from) {
  to_from = cv::Mat::eye(3, 3, CV_64F);
  if (std::min(from.picture.cols, from.picture.rows) < 32) return false;
  std::vector<cv::Point2f> a, b;
  track_corners(from, to, a, b);
  if (a.size() < fewest_corners) return false;
  cv::theRNG().state = 0x5eed;
  cv::Mat inliers;
  const cv::Mat found = cv::findHomography(a, b, cv::RANSAC, 1.5, inliers, 500, 0.995);
  if (found.empty() || cv::countNonZero(inliers) < fewest_corners || !cv::checkRange(found)) return false;
  to_from = found;
  return true;
}

}  // namespace uwv::layers
