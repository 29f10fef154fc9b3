// SPDX-License-Identifier: Apache-2.0
// From a reconstruction in tracked pixels and of one shot to the result for the whole clip, in full pixels.
#pragma once

#include "geometry/sfm/bundle_adjustment.h"
#include "uwv/geometry/structure_from_motion.h"

namespace uwv::sfm {

struct Placement {
  int shot_begin = 0;
  int clip_frames = 0;
  Size full, tracked;
};

/// Cameras of all frames: measured, interpolated between measured ones, or their nearest. The first measured camera is
/// the world.
void fill_cameras(SfmResult& result, const Reconstruction& reconstruction, const Placement& placement);
/// rms_error_px and moving_share.
void fill_errors(SfmResult& result, const Reconstruction& reconstruction, const std::vector<Track>& tracks,
                 double max_error_px, double scale);
/// Points with two or more inliers; then everything is scaled so that the first camera's median depth is 1.
void fill_points(SfmResult& result, const Reconstruction& reconstruction, const std::vector<Track>& tracks,
                 double max_error_px, const Placement& placement);

}  // namespace uwv::sfm
