// SPDX-License-Identifier: Apache-2.0
#include "bench/geometry_scores.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "bench/timing.h"

namespace uwv::bench {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

double path_length(std::span<const Camera> cameras) {
  double sum = 0;
  for (std::size_t i = 1; i < cameras.size(); ++i)
    sum += (cameras[i].world_from_cam.translation - cameras[i - 1].world_from_cam.translation).norm();
  return sum;
}

/// The rotation R that minimises the sum of |R a_i - b_i|^2 over rotations.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& sum_of_b_a) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum_of_b_a, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d rotation = svd.matrixU() * svd.matrixV().transpose();
  const Eigen::Vector3d signs(1, 1, rotation.determinant() < 0 ? -1 : 1);
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

/// Orientations are aligned by themselves: centres on a line would leave the turn about it open.
double rotation_error_deg(const std::vector<Eigen::Matrix3d>& found, const std::vector<Eigen::Matrix3d>& truth) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < found.size(); ++i) sum += truth[i] * found[i].transpose();
  const Eigen::Matrix3d true_from_found = nearest_rotation(sum);
  double squares = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double angle = Eigen::AngleAxisd(truth[i].transpose() * true_from_found * found[i]).angle();
    squares += angle * angle;
  }
  return std::sqrt(squares / static_cast<double>(found.size())) * 180 / std::numbers::pi;
}

/// Calls visit(true depth, found depth, confidence) where the truth is known and at rest.
template <class Visitor>
void for_each_true_pixel(std::span<const FrameGeometry> found, const TrueClip& truth, const Visitor& visit) {
  for (std::size_t f = 0; f < found.size(); ++f)
    for (std::size_t i = 0; i < truth.depths[f].pixels().size(); ++i) {
      const bool at_rest = truth.static_pixels.empty() || truth.static_pixels[f].pixels()[i] != 0;
      const double depth = static_cast<double>(truth.depths[f].pixels()[i]);
      if (at_rest && depth > 0)
        visit(depth, static_cast<double>(found[f].depth.pixels()[i]),
              static_cast<double>(found[f].confidence.pixels()[i]));
    }
}

}  // namespace

CameraScore score_cameras(std::span<const Camera> found, std::span<const std::uint8_t> registered,
                          std::span<const Camera> truth) {
  std::vector<Eigen::Vector3d> found_centres, true_centres;
  std::vector<Eigen::Matrix3d> found_turns, true_turns;
  for (std::size_t i = 0; i < std::min(found.size(), truth.size()); ++i) {
    if (!registered.empty() && registered[i] == 0) continue;
    found_centres.push_back(found[i].world_from_cam.translation);
    true_centres.push_back(truth[i].world_from_cam.translation);
    found_turns.push_back(found[i].world_from_cam.rotation);
    true_turns.push_back(truth[i].world_from_cam.rotation);
  }
  const auto count = static_cast<Eigen::Index>(found_centres.size());
  CameraScore score{static_cast<int>(count), nan, nan, nan, nan, nan};
  if (count < 3) return score;
  const Eigen::Map<const Eigen::Matrix3Xd> from(found_centres.front().data(), 3, count),
      to(true_centres.front().data(), 3, count);
  const Eigen::Matrix4d similarity = Eigen::umeyama(from, to, true);
  const Eigen::Matrix3Xd aligned =
      (similarity.topLeftCorner<3, 3>() * from).colwise() + similarity.topRightCorner<3, 1>();
  score.scale = std::cbrt(similarity.topLeftCorner<3, 3>().determinant());
  score.ate = std::sqrt((aligned - to).colwise().squaredNorm().mean());
  score.ate_percent = 100 * score.ate / path_length(truth);
  score.rotation_deg = rotation_error_deg(found_turns, true_turns);
  score.focal_percent = 100 * (found.front().intrinsics.fx / truth.front().intrinsics.fx - 1);
  return score;
}

DepthScore score_depth(std::span<const FrameGeometry> found, const TrueClip& truth, double scale) {
  require(found.size() == truth.depths.size(), "{} depths were found for {} frames", found.size(), truth.depths.size());
  DepthScore score;
  score.scale = scale;
  if (scale == 0) {
    std::vector<double> ratios;
    for_each_true_pixel(found, truth, [&](double depth, double ours, double) {
      if (ours > 0) ratios.push_back(depth / ours);
    });
    score.scale = ratios.empty() ? nan : median(std::move(ratios));
  }
  double pixels = 0, known = 0, measured = 0, within_5 = 0, within_25 = 0, error = 0, measured_error = 0;
  for_each_true_pixel(found, truth, [&](double depth, double ours, double confidence) {
    ++pixels;
    if (!(ours > 0)) return;
    const double ratio = score.scale * ours / depth, off = std::abs(ratio - 1);
    const double factor = std::max(ratio, 1 / ratio);
    ++known;
    error += off;
    within_5 += factor < 1.05;
    within_25 += factor < 1.25;
    if (confidence < 0.5) return;
    ++measured;
    measured_error += off;
  });
  score.abs_rel = error / known;
  score.measured_abs_rel = measured_error / measured;
  score.within_5 = within_5 / known;
  score.within_25 = within_25 / known;
  score.known = known / pixels;
  score.measured = measured / pixels;
  return score;
}

}  // namespace uwv::bench
