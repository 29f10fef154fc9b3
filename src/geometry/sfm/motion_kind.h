// SPDX-License-Identifier: Apache-2.0
// Did the camera stand still, turn, or move? Asked before anything is reconstructed.
#pragma once

#include <string>
#include <vector>

#include "geometry/sfm/feature_tracks.h"

namespace uwv::sfm {

/// The frames [first, last] of one shot.
struct Shot {
  int first = 0, last = 0;
  int frames() const { return last - first + 1; }
};

struct MotionKind {
  ClipMotion motion = ClipMotion::indeterminate;
  std::string reason;
  double parallax_px = 0;  ///< The largest, over pairs of frames, of the median shift no rotation explains.
  double focal = 0;        ///< The focal length (pixels) that explains turning best; 0 = nothing to go by.
};

/// `focals`: hypotheses in pixels; a known lens gives one.
MotionKind kind_of_motion(const std::vector<Track>& tracks, const Shot& shot, const Intrinsics& intrinsics,
                          const std::vector<double>& focals, const SfmOptions& options);

}  // namespace uwv::sfm
