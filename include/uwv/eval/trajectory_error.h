// SPDX-License-Identifier: Apache-2.0
// How far an estimated camera track is from the true one, when scale, place and heading of the whole are arbitrary
// (Umeyama 1991; the measures of Sturm et al. 2012).
#pragma once

#include <span>

#include "uwv/core/camera.h"

namespace uwv {

/// x_in_truth = scale * rotation * x_in_estimate + translation.
struct Similarity {
  double scale = 1;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Vector3d operator*(const Eigen::Vector3d& x) const { return scale * (rotation * x) + translation; }
};

/// The similarity that brings the estimated camera centres nearest to the true ones (least squares). Centres that do
/// not fix it are completed from the cameras' headings: where the centres lie on a line or are fewer than three, the
/// rotation is the mean of the headings' differences (chordal), and where either track's centres all coincide the scale
/// is 1. Throws std::invalid_argument for no cameras, different counts or values that are not finite.
Similarity align_tracks(std::span<const Rigid3> estimate_world_from_cam, std::span<const Rigid3> truth_world_from_cam);

struct TrajectoryError {
  Similarity truth_from_estimate;
  double ate_rmse = 0;  ///< Of the aligned centres, in units of the truth.
  double ate_max = 0;
  double truth_length = 0;   ///< Of the true path, to put the errors into proportion.
  double rotation_mean = 0;  ///< Degrees, after turning all estimated headings by their mean difference.
  double rotation_max = 0;
  /// Of the motion between frames `gap` apart: translation (units of the truth, root mean square) and rotation
  /// (degrees, mean); both 0 when the track is no longer than the gap.
  double relative_translation_rmse = 0;
  double relative_rotation_mean = 0;
};
/// Throws as align_tracks, and for a gap below 1.
TrajectoryError trajectory_error(std::span<const Rigid3> estimate_world_from_cam,
                                 std::span<const Rigid3> truth_world_from_cam, int gap = 1);

/// Degrees between two rotations, 0..180.
double rotation_angle(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b);

}  // namespace uwv
