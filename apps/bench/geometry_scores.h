// SPDX-License-Identifier: Apache-2.0
// Cameras and depth found from pictures, against what is true. Reconstructions have a frame and a scale of their own,
// which is taken out first: one similarity for all cameras, one factor for all depths.
#pragma once

#include <cstdint>
#include <span>

#include "bench/true_clip.h"
#include "uwv/geometry/scene_geometry.h"

namespace uwv::bench {

/// NaN where there is nothing to judge: fewer than three cameras.
struct CameraScore {
  int cameras = 0;           ///< Judged: the registered ones.
  double ate = 0;            ///< Root mean square distance of centres after alignment, in the truth's unit.
  double ate_percent = 0;    ///< The same, of the length of the true path.
  double rotation_deg = 0;   ///< Root mean square angle, after the rotation that aligns all orientations best.
  double focal_percent = 0;  ///< How much too long (positive) or short the first camera's fx is.
  double scale = 0;          ///< Truth's units per unit of the reconstruction.
};

/// `registered`: empty = all; else 1 = judged.
CameraScore score_cameras(std::span<const Camera> found, std::span<const std::uint8_t> registered,
                          std::span<const Camera> truth);

/// Over pixels where both depths are known and the scene is at rest.
struct DepthScore {
  double abs_rel = 0;           ///< Mean |found - true| / true.
  double measured_abs_rel = 0;  ///< The same where the confidence is 0.5 or more.
  double within_5 = 0;          ///< Share with a ratio to the truth below 1.05.
  double within_25 = 0;         ///< Share with a ratio below 1.25 (the usual delta 1).
  double known = 0;             ///< Share of the pixels with true depth for which one was found.
  double measured = 0;          ///< Share of them with a confidence of 0.5 or more.
  double scale = 0;             ///< What found depths were multiplied with.
};

/// `scale` 0 = the median ratio of true and found depth.
DepthScore score_depth(std::span<const FrameGeometry> found, const TrueClip& truth, double scale);

}  // namespace uwv::bench
