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
  double ate_percent = 0;    ///< The same, of the length of the judged cameras' true path.
  double rotation_deg = 0;   ///< Mean angle, after the rotation that aligns all orientations best.
  double focal_percent = 0;  ///< How much too long (positive) or short the first camera's fx is.
  double scale = 0;          ///< Truth's units per unit of the reconstruction.
};

/// As trajectory_error(). `registered`: empty = all; else 1 = judged.
CameraScore score_cameras(std::span<const Camera> found, std::span<const std::uint8_t> registered,
                          std::span<const Camera> truth);

/// Over pixels where the truth is known and the scene is at rest. NaN for shares of nothing.
struct DepthScore {
  double abs_rel = 0;           ///< Mean |found - true| / true where both are known.
  double measured_abs_rel = 0;  ///< The same where the confidence is 0.5 or more.
  double delta_125 = 0;         ///< Share of the known with a ratio to the truth below 1.25 either way.
  double edge_f = 0;            ///< F-score of all frames' depth edges; see compare_depth_edges().
  double flicker = 0;           ///< temporal_flicker(), by the true cameras.
  double known = 0;             ///< Share of the pixels with true depth for which one was found.
  double measured = 0;          ///< Share of them with a confidence of 0.5 or more.
  double scale = 0;             ///< What found depths were multiplied with.
};

/// `scale` 0 = the median ratio of true and found depth, one for the clip.
DepthScore score_depth(std::span<const FrameGeometry> found, const TrueClip& truth, double scale);

}  // namespace uwv::bench
