// SPDX-License-Identifier: Apache-2.0
// A reconstruction under way, and its refinement: cameras, points and the focal length moved together until the
// reprojections agree best (Triggs et al. 1999).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "geometry/sfm/tracks.h"
#include "uwv/core/camera.h"

namespace uwv::sfm {

/// Poses by frame and points by track; empty = not known (yet).
struct Reconstruction {
  Intrinsics lens;
  std::vector<std::optional<Rigid3>> cam_from_world;
  std::vector<std::optional<Eigen::Vector3d>> points;

  /// Reprojection error in pixels; infinite behind the camera or where either is unknown.
  double error(const Track& track, std::size_t index, int frame) const;
  /// The same for a camera that stands at `pose`; the point must be known.
  double error_from(const Rigid3& pose, const Track& track, std::size_t index, int frame) const;
  std::vector<int> registered() const;
};

struct AdjustOptions {
  bool refine_focal = false;
  double focal_prior = 0;        ///< Expected fx; a prior of 0.5 in log f keeps an unobservable focal length in place.
  bool move_points = true;       ///< False: only the cameras move.
  bool fix_translation = false;  ///< True: rotations (and points at infinity) only.
  double gate_px = 4;            ///< Observations farther off take no part.
  double loss_px = 1;  ///< Scale of the Cauchy loss: an observation farther off than this counts less and less.
  int iterations = 20;
  double tolerance = 1e-5;  ///< Ends when a step gains less than this share of the cost.
};
/// Root mean square error of the observations that took part. The first registered camera stays where it is.
double adjust(Reconstruction& reconstruction, const std::vector<Track>& tracks, const AdjustOptions& options);

/// The frame's camera moved alone, from `pose`; the points stay. `seen`: the tracks with a point that the frame shows.
Rigid3 adjusted_camera(const Reconstruction& reconstruction, const std::vector<Track>& tracks,
                       std::span<const std::size_t> seen, int frame, const Rigid3& pose, double gate_px);

}  // namespace uwv::sfm
