// SPDX-License-Identifier: Apache-2.0
// Adding a camera to points that are already known.
#pragma once

#include "geometry/sfm/bundle_adjustment.h"

namespace uwv::sfm {

/// The pose of `frame` from the points its tracks have: from a nearby camera's pose when that converges, else by RANSAC
/// over minimal sets drawn by the seed. Empty when fewer than 10 tracks or 30 % of them agree.
std::optional<Rigid3> find_pose(const Reconstruction& reconstruction, const std::vector<Track>& tracks, int frame,
                                double max_error_px, std::uint64_t seed);
/// Gives the frame that pose, or none. True when there is one.
bool resect(Reconstruction& reconstruction, const std::vector<Track>& tracks, int frame, double max_error_px,
            std::uint64_t seed);

}  // namespace uwv::sfm
