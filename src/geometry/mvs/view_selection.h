// SPDX-License-Identifier: Apache-2.0
// Which views to compare a frame with, between which depths, and how densely in time.
#pragma once

#include <vector>

#include "geometry/mvs/view.h"

namespace uwv::mvs {

/// Inverse depths between which planes are laid, normalised.
struct DepthRange {
  float farthest = 0;  ///< Smallest inverse depth.
  float nearest = 0;   ///< Largest inverse depth; 0 = nothing is known.
};

/// What the choice of views and ranges is made from.
struct SparseScene {
  std::vector<Camera> cameras;          ///< Normalised.
  std::vector<Eigen::Vector3d> points;  ///< Normalised.
};

/// Robust bounds of what the frame sees (2nd and 98th percentile, widened), or of what all frames see when it sees too
/// little; from the cameras' distances when there are no points at all.
DepthRange depth_range(const SparseScene& scene, std::size_t frame);

/// Up to `count` other frames, best first. A good one sees the same points from 2 to 10 degrees apart and not from
/// where another chosen one stands. Empty when no other camera is displaced enough for parallax.
std::vector<int> choose_neighbours(const SparseScene& scene, std::size_t frame, int count);

/// The largest stride whose keys are at most `max_flow_share` of the picture's width of median flow apart.
int choose_key_stride(const SparseScene& scene);

}  // namespace uwv::mvs
