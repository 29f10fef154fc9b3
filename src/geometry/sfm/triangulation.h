// SPDX-License-Identifier: Apache-2.0
// Points from the rays of registered cameras.
#pragma once

#include <numbers>

#include "geometry/sfm/bundle_adjustment.h"

namespace uwv::sfm {

/// Radians between the rays of a point worth having; below, its depth is mostly noise.
inline constexpr double min_ray_angle = 0.7 * std::numbers::pi / 180;

/// The point nearest to the rays of the given frames; nullopt when it lies behind one, when the rays' largest angle is
/// below `min_angle` (radians), or when no half of the observations agrees within `max_error` pixels.
std::optional<Eigen::Vector3d> triangulate(const Reconstruction& reconstruction, const Track& track, double max_error,
                                           double min_angle);
/// Gives a point to every track that has none and can have one, and takes it from those that disagree with most of
/// their observations. Returns how many tracks have one.
int triangulate_all(Reconstruction& reconstruction, const std::vector<Track>& tracks, double max_error,
                    double min_angle);

}  // namespace uwv::sfm
