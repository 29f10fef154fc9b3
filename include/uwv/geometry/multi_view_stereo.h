// SPDX-License-Identifier: Apache-2.0
// Dense depth of every frame of a clip whose cameras are known, from its neighbours in time.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "uwv/core/mask.h"
#include "uwv/core/monitor.h"
#include "uwv/core/thread_pool.h"
#include "uwv/geometry/scene_geometry.h"
#include "uwv/geometry/structure_from_motion.h"

namespace uwv {

struct MvsOptions {
  int neighbours = 4;         ///< Other views compared with, chosen for baseline and overlap. More: fewer holes, slower.
  int planes = 64;            ///< Depth hypotheses, uniform in inverse depth. More: finer, slower.
  double scale = 0.75;        ///< Matching resolution relative to the frame. 1: sharper edges, 1.6x the time; 0.5: half of it.
  int key_stride = 0;         ///< Match every n-th frame and carry depth to those between by warping; 0 = by the motion.
  double consistency = 0.02;  ///< Largest relative depth difference between views that count as agreeing.
  bool complete = true;       ///< Fill what matching could not see, along edges of the picture, with low confidence.
  /// Throws std::invalid_argument when a value is out of range.
  void check() const;
};

struct MvsSummary {
  int matched_frames = 0;    ///< Frames that were matched; the others were carried over.
  double measured_share = 0; ///< Pixels with confidence of 0.5 and more, of all.
  double seconds = 0;
  std::vector<std::string> notes;
  std::string brief() const;
};

/// `cameras` one per frame, `points` bound the depth range. `moving`: empty or one mask a frame, 1 = static and usable
/// (moving pixels are not matched). On return `frames_out` has one entry per frame, in the cameras' unit. Depth of
/// moving pixels is left 0 (see moving_objects.h). Throws std::invalid_argument when sizes disagree.
MvsSummary multi_view_stereo(std::span<const ImageRgb> frames, std::span<const Camera> cameras,
                             std::span<const ScenePoint> points, std::span<const ValidityMask> static_pixels,
                             const MvsOptions& options, ThreadPool& pool, Monitor& monitor,
                             std::vector<FrameGeometry>& frames_out);

}  // namespace uwv
