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

/// Time and error are of 21 frames of 640x480 of a living room with known cameras (docs/performance.md): the defaults
/// take 0.12 s of one processor a frame, are 1.0% off where measured (93% of the pixels), and 1.2% in all.
struct MvsOptions {
  /// Other views compared with, chosen for baseline and overlap; 1 to 16. 4 see most of what occlusion hides from two:
  /// with 2, three quarters of the time, 88% measured.
  int neighbours = 4;
  /// Depth hypotheses, uniform in inverse depth; 4 to 1024. 64 are about a pixel of parallax each; 32 take three
  /// quarters of the time and measure 92%, 128 take 1.5 times as long and gain little. Two views far apart gain from
  /// 128.
  int planes = 64;
  /// Matching resolution relative to the frame, above 0 to 1. 0.5 takes half the time and blurs thin things (1.3% off
  /// in all); 1 takes 1.6 times as long, is no less off, and measures fewer (91%).
  double scale = 0.75;
  /// Match every n-th frame, and the last, and carry depth to those between by warping. 0 = the longest of 1 to 4 that
  /// moves four fifths of the keys by less than 2% of the picture's width; carrying costs little accuracy there.
  int key_stride = 0;
  /// Largest relative depth difference between views that count as agreeing, above 0 to 0.5: 2% is several planes.
  double consistency = 0.02;
  /// Fill what matching could not see, along edges of the picture, with confidence below 0.5: points are wanted
  /// everywhere, and the confidence says where not to trust them.
  bool complete = true;
  /// Throws std::invalid_argument when a value is out of range.
  void check() const;
};

struct MvsSummary {
  int matched_frames = 0;     ///< Frames that were matched; the others were carried over.
  double measured_share = 0;  ///< Pixels with confidence of 0.5 and more, of all.
  double seconds = 0;
  std::vector<std::string> notes;
  std::string brief() const;
};

/// Plane sweep, semi-global aggregation (Hirschmueller, PAMI 2008), steps of depth moved to the picture's edges by
/// medians weighted by colour, agreement between views, filling along edges of colour. Results do not depend on the
/// number of threads, nor but for roundings on the unit or the world's origin.
///
/// `cameras` one per frame; `points` bound the depth range (their observations are not used; without points the range
/// is guessed from the cameras' distances, and noted). `static_pixels`: empty or one mask a frame, which may be empty;
/// 1 = static and usable, 0 = moving and not matched. On return `frames_out` has one entry per frame, in the cameras'
/// unit. Depth of moving pixels is left 0 (see moving_objects.h).
///
/// Confidence is 0.5 and more exactly where another view confirmed the depth; frames between keys have their keys'. One
/// frame, or cameras at one place, leave all depth unknown, and that is noted. The scene is taken to be static, in
/// static light. Reports stages "preparing", "matching", "confirming", "lending", "completing" to the monitor. Throws
/// std::invalid_argument for no frames, sizes that disagree, or cameras that are not finite.
MvsSummary multi_view_stereo(std::span<const ImageRgb> frames, std::span<const Camera> cameras,
                             std::span<const ScenePoint> points, std::span<const ValidityMask> static_pixels,
                             const MvsOptions& options, ThreadPool& pool, Monitor& monitor,
                             std::vector<FrameGeometry>& frames_out);

}  // namespace uwv
