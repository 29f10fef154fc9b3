// SPDX-License-Identifier: Apache-2.0
#include "uwv/eval/trajectory_error.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace uwv {
namespace {

void check_tracks(std::span<const Rigid3> a, std::span<const Rigid3> b) {
  require(!a.empty(), "camera tracks need at least one camera");
  require(a.size() == b.size(), "camera tracks of {} and {} cameras cannot be compared", a.size(), b.size());
  for (const auto& track : {a, b})
    for (const Rigid3& pose : track)
      require(pose.rotation.allFinite() && pose.translation.allFinite(), "a camera pose is not finite");
}

/// The rotation nearest to `m` (largest trace of R^T m).
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& m) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

Eigen::Matrix3d mean_heading_difference(std::span<const Rigid3> estimate, std::span<const Rigid3> truth) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < truth.size(); ++i) sum += truth[i].rotation * estimate[i].rotation.transpose();
  return nearest_rotation(sum);
}

Eigen::Vector3d mean_centre(std::span<const Rigid3> track) {
  // Offsets from the first centre, so that a track far from the origin loses nothing.
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Rigid3& pose : track) sum += pose.translation - track.front().translation;
  return track.front().translation + sum / static_cast<double>(track.size());
}

}  // namespace

double rotation_angle(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  const Eigen::Matrix3d d = a.transpose() * b;
  const Eigen::Vector3d axis(d(2, 1) - d(1, 2), d(0, 2) - d(2, 0), d(1, 0) - d(0, 1));
  return std::atan2(axis.norm(), d.trace() - 1) * 180 / std::numbers::pi;
}

Similarity align_tracks(std::span<const Rigid3> estimate, std::span<const Rigid3> truth) {
  check_tracks(estimate, truth);
  const Eigen::Vector3d centre_e = mean_centre(estimate), centre_t = mean_centre(truth);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double spread_e = 0, spread_t = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Eigen::Vector3d e = estimate[i].translation - centre_e, t = truth[i].translation - centre_t;
    covariance += t * e.transpose();
    spread_e += e.squaredNorm();
    spread_t += t.squaredNorm();
  }
  Similarity out;
  // The first two singular values must stand out for the centres alone to fix the rotation.
  const Eigen::Vector3d singular = Eigen::JacobiSVD<Eigen::Matrix3d>(covariance).singularValues();
  const bool fixed = truth.size() >= 3 && singular[1] > 1e-6 * singular[0] && singular[0] > 0;
  out.rotation = fixed ? nearest_rotation(covariance) : mean_heading_difference(estimate, truth);
  const double along = (out.rotation.transpose() * covariance).trace();
  const bool scaled = spread_e > 0 && spread_t > 0 && along > 0;
  out.scale = scaled ? along / spread_e : 1;
  out.translation = centre_t - out.scale * (out.rotation * centre_e);
  return out;
}

TrajectoryError trajectory_error(std::span<const Rigid3> estimate, std::span<const Rigid3> truth, int gap) {
  require(gap >= 1, "a gap of {} frames is below 1", gap);
  TrajectoryError out;
  out.truth_from_estimate = align_tracks(estimate, truth);
  const Similarity& s = out.truth_from_estimate;
  const Eigen::Vector3d centre_e = mean_centre(estimate), centre_t = mean_centre(truth);
  const Eigen::Matrix3d heading = mean_heading_difference(estimate, truth);
  const auto n = static_cast<double>(truth.size());
  double squares = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Eigen::Vector3d aligned = s.scale * (s.rotation * (estimate[i].translation - centre_e));
    const double distance = (aligned - (truth[i].translation - centre_t)).norm();
    squares += distance * distance;
    out.ate_max = std::max(out.ate_max, distance);
    const double angle = rotation_angle(heading * estimate[i].rotation, truth[i].rotation);
    out.rotation_mean += angle / n;
    out.rotation_max = std::max(out.rotation_max, angle);
    if (i > 0) out.truth_length += (truth[i].translation - truth[i - 1].translation).norm();
  }
  out.ate_rmse = std::sqrt(squares / n);
  const auto step = static_cast<std::size_t>(gap);
  if (truth.size() <= step) return out;
  const auto pairs = static_cast<double>(truth.size() - step);
  double relative = 0;
  for (std::size_t i = 0; i + step < truth.size(); ++i) {
    const auto motion = [&](std::span<const Rigid3> track, double scale) {
      const Eigen::Matrix3d back = track[i].rotation.transpose();
      return Rigid3{back * track[i + step].rotation,
                    scale * (back * (track[i + step].translation - track[i].translation))};
    };
    const Rigid3 e = motion(estimate, s.scale), t = motion(truth, 1);
    relative += (e.translation - t.translation).squaredNorm();
    out.relative_rotation_mean += rotation_angle(e.rotation, t.rotation) / pairs;
  }
  out.relative_translation_rmse = std::sqrt(relative / pairs);
  return out;
}

}  // namespace uwv
