// SPDX-License-Identifier: Apache-2.0
#include "geometry/sfm/two_view.h"

#include <algorithm>
#include <opencv2/calib3d.hpp>

namespace uwv::sfm {
namespace {

Eigen::Matrix3d to_eigen(const cv::Mat& m) {
  Eigen::Matrix3d out;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) out(r, c) = m.at<double>(r, c);
  return out;
}

/// Matches, in the order given, on the plane z = 1, where one lens fits all.
std::vector<cv::Point2d> normalised(const std::vector<Eigen::Vector2d>& pixels, std::span<const std::size_t> order,
                                    const Intrinsics& lens) {
  std::vector<cv::Point2d> out;
  for (const std::size_t i : order) {
    const Eigen::Vector3d ray = unproject(lens, pixels[i], 1);
    out.emplace_back(ray.x(), ray.y());
  }
  return out;
}

Rigid3 pose_from(const cv::Mat& rotation, const cv::Mat& translation) {
  Eigen::Vector3d t(translation.at<double>(0), translation.at<double>(1), translation.at<double>(2));
  return {to_eigen(rotation), t.normalized()};
}

/// Homographies hold four poses, two of which see the plane from in front.
void add_plane_starts(const std::vector<cv::Point2d>& a, const std::vector<cv::Point2d>& b, double threshold,
                      int needed, const FramePair& pair, std::vector<TwoViewStart>& out) {
  cv::Mat inliers;
  const cv::Mat h = cv::findHomography(a, b, cv::RANSAC, threshold, inliers, 500, 0.999);
  if (h.empty() || cv::countNonZero(inliers) < needed) return;
  std::vector<cv::Mat> rotations, translations, normals;
  cv::decomposeHomographyMat(h, cv::Mat::eye(3, 3, CV_64F), rotations, translations, normals);
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    if (cv::norm(translations[i]) < 1e-6) continue;
    int front = 0, total = 0;
    for (std::size_t k = 0; k < a.size(); k += 5) {
      const cv::Mat& n = normals[i];
      front += n.at<double>(0) * a[k].x + n.at<double>(1) * a[k].y + n.at<double>(2) > 0;
      ++total;
    }
    if (10 * front > 9 * total) out.push_back({pair, pose_from(rotations[i], translations[i]), true});
  }
}

}  // namespace

std::vector<FramePair> rank_pairs(const std::vector<Track>& tracks, std::span<const FramePair> pairs,
                                  const Intrinsics& lens, Size size) {
  std::vector<std::pair<double, std::size_t>> scored;
  const double plenty = 0.04 * size.width;  // more parallax than this helps no further
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const PairMatches matches = matches_between(tracks, pairs[i].a, pairs[i].b);
    const double parallax = median(rotation_residuals(matches, lens, fit_rotation(matches, lens)));
    scored.emplace_back(-std::min(1.0, parallax / plenty) * std::min(300.0, static_cast<double>(matches.size())), i);
  }
  std::sort(scored.begin(), scored.end());
  std::vector<FramePair> out;
  for (const auto& [score, i] : scored) out.push_back(pairs[i]);
  return out;
}

std::vector<TwoViewStart> starts_of(const std::vector<Track>& tracks, const FramePair& pair, const Intrinsics& lens,
                                    double max_error_px, std::uint64_t seed) {
  const PairMatches matches = matches_between(tracks, pair.a, pair.b);
  std::vector<TwoViewStart> out;
  if (matches.size() < 12) return out;
  const std::vector<std::size_t> order = drawing_order(matches.size(), seed);
  const std::vector<cv::Point2d> a = normalised(matches.a, order, lens), b = normalised(matches.b, order, lens);
  const double threshold = 0.5 * max_error_px / std::max(lens.fx, lens.fy);
  cv::Mat inliers;
  cv::Mat essential = cv::findEssentialMat(a, b, 1.0, {0, 0}, cv::RANSAC, 0.999, threshold, 300, inliers);
  int agreeing = 0;
  if (essential.rows >= 3) {
    essential = essential.rowRange(0, 3).clone();
    agreeing = cv::countNonZero(inliers);
    cv::Mat rotation, translation;
    const int front = cv::recoverPose(essential, a, b, rotation, translation, 1.0, {0, 0}, inliers);
    if (front >= 12) out.push_back({pair, pose_from(rotation, translation), false});
  }
  add_plane_starts(a, b, 2 * threshold, std::max(12, agreeing * 85 / 100), pair, out);
  return out;
}

}  // namespace uwv::sfm
