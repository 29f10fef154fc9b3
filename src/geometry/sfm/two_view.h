// SPDX-License-Identifier: Apache-2.0
// What two frames alone tell: the rotation that explains them best, and the relative pose.
#pragma once

#include <optional>
#include <vector>

#include "geometry/sfm/feature_tracks.h"
#include "uwv/core/camera.h"

namespace uwv::sfm {

/// How well a camera that only turned explains a pair of frames.
struct RotationFit {
  Eigen::Matrix3d b_from_a = Eigen::Matrix3d::Identity();
  double residual_px = 0;  ///< Median shift it leaves unexplained.
};
RotationFit fit_rotation(const std::vector<Pair>& pairs, const Intrinsics& intrinsics, std::uint64_t seed);

struct RelativePose {
  Rigid3 b_from_a;  ///< Translation of unit length.
  std::vector<std::size_t> inliers;  ///< Indices into the pairs.
  double median_angle = 0;           ///< Between the rays to a point, radians.
};
/// Nothing when too few pairs agree or too few points lie in front of both cameras.
std::optional<RelativePose> relative_pose(const std::vector<Pair>& pairs, const Intrinsics& intrinsics,
                                          double max_error_px);

/// A point from two or more views by linear least squares; nothing when it lies behind a camera or is undetermined.
std::optional<Eigen::Vector3d> triangulate(const std::vector<Rigid3>& cams_from_world,
                                           const std::vector<Eigen::Vector2d>& pixels, const Intrinsics& intrinsics);

}  // namespace uwv::sfm
