// SPDX-License-Identifier: Apache-2.0
// A camera that turns about one point: rotations and focal length, no depth.
#pragma once

#include "geometry/sfm/incremental.h"

namespace uwv::sfm {

/// Rotations of all frames that can be linked, adjusted together; the points are directions of length 1.
Reconstruction turn(const std::vector<Track>& tracks, int frames, const Intrinsics& lens, const GrowOptions& options);

}  // namespace uwv::sfm
