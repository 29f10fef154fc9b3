// SPDX-License-Identifier: Apache-2.0
// What a clip is like, in a few numbers, and what its geometry therefore needs: model only what the scene requires.
//
// plan_geometry() is a pure function of the numbers. Every choice comes with its reason, with what it saves, and can be
// forced; where it is forced the reason goes on to say what would have been chosen.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "uwv/core/image.h"
#include "uwv/geometry/scene_geometry.h"
#include "uwv/geometry/structure_from_motion.h"

namespace uwv {

/// Numbers about a clip. Shares are 0..1. NaN, infinite and negative values count as unknown.
struct SceneProfile {
  Size size;  ///< Of a frame.
  int frames = 0;
  ClipMotion motion = ClipMotion::indeterminate;
  double parallax_px = 0;  ///< Median shift over the clip that rotation cannot explain (SfmResult).
  /// Median shift from one frame to the next that rotation cannot explain; 0 = unknown, then parallax_px spread evenly
  /// over the frames stands for it.
  double parallax_per_frame_px = 0;
  double rms_error_px = 0;        ///< Of the reconstruction's observations (SfmResult).
  double registered_share = 0;    ///< Frames whose pose was measured, of all.
  double moving_share = 0;        ///< Pixels that move by themselves (MovingPixels).
  double measured_share = 0;      ///< Depths that are measured (MvsSummary); 0 = no depth yet.
  double disocclusion_share = 0;  ///< Pixels of the asked path that no single frame's points cover.
  double depth_ratio = 1;         ///< Far over near: 95th over 5th percentile of depth.
  int cuts = 0;
  std::string brief() const;  ///< One line.
};

/// How points are kept.
enum class CloudKind {
  per_frame,  ///< Each frame is drawn from its own points.
  merged,     ///< Also from what other frames saw of the static scene, moving points per frame (other_views.h).
};
std::string_view to_string(CloudKind kind);

struct GeometryPlanOptions {
  double min_parallax_px = 2;         ///< Below this depth from motion is noise: tracking errs by a tenth of it.
  double max_error_px = 2;            ///< A reconstruction that reprojects worse is not believed.
  double min_registered_share = 0.5;  ///< Fewer measured poses: most cameras would be guesses.
  double max_moving_share = 0.5;      ///< More of the picture moving: what is static, and so the camera, is uncertain.
  double min_measured_share = 0.3;    ///< Less measured depth is not worth merging. Ignored while there is none yet.
  double min_disocclusion = 0.02;     ///< Smaller uncovered shares are left to the generator.
  double min_depth_ratio = 1.3;       ///< Flatter scenes uncover nothing behind anything.
  double min_layer_motion = 0.005;    ///< From this share of moving pixels on foreground is kept apart.
  /// Frames whose depth is computed may be so far apart that this parallax lies between them: nearer ones repeat the
  /// work, farther ones lose depth on the way. docs/performance.md has what 1 to 8 frames cost and keep.
  double key_parallax_px = 2;
  int max_key_stride = 4;  ///< Depth carried farther than this drifts.

  std::optional<GeometryProvider> provider;  ///< Forced when set, as are those below.
  std::optional<CloudKind> cloud;
  std::optional<bool> layers;
  std::optional<int> key_stride;  ///< >= 1.
  std::optional<bool> decimate;
  /// Throws std::invalid_argument when a value is out of range.
  void check() const;
};

/// One choice.
template <class T>
struct PlanDecision {
  T choice{};
  std::string reason;   ///< One sentence with the numbers that decided.
  std::string saves;    ///< What it saves, or costs, compared with the alternative.
  bool forced = false;  ///< By the options; the reason then ends with what the numbers say.
};

struct GeometryPlan {
  PlanDecision<GeometryProvider> provider;  ///< sfm or prior, unless forced.
  PlanDecision<CloudKind> cloud;
  PlanDecision<bool> layers;       ///< Foreground and background apart.
  PlanDecision<int> key_stride;    ///< Dense depth on every n-th frame, carried to those between.
  PlanDecision<bool> decimate;     ///< See decimation.h.
  std::vector<std::string> notes;  ///< Numbers that were unusable and what they were taken for.
  std::string brief() const;       ///< One line.
};

/// Deterministic; later decisions take earlier ones, forced or not, into account. Never throws for what the profile
/// says; std::invalid_argument for the options.
GeometryPlan plan_geometry(const SceneProfile& profile, const GeometryPlanOptions& options);

}  // namespace uwv
