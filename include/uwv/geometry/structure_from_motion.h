// SPDX-License-Identifier: Apache-2.0
// Cameras and sparse points of an ordinary clip, from its pictures alone.
//
// Features are tracked from frame to frame. Pairs of frames with parallax begin small reconstructions; the one that
// fits best grows over the key frames, is adjusted (Ceres), and the frames between are resected into it. What a clip
// cannot tell (a camera that only turns, stands still, or sees one plane; a cut) is recognised and named: the result's
// `motion` and `reason` say so, and no camera is invented. The scale is arbitrary: the median depth of the points seen
// from the first camera is 1. The world is the first registered camera's frame, so that where the scene lies in any
// other world, however far from its origin, plays no part.
//
// Lucas & Kanade 1981 (tracks), Nister 2004 (two views), Schoenberger & Frahm 2016 (growing), Triggs et al. 1999
// (adjustment). Without given intrinsics several focal lengths are tried on the beginnings and the best one is refined;
// a scene that is one plane says next to nothing about the lens, and the result is then as good as that guess.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "uwv/core/camera.h"
#include "uwv/core/image.h"
#include "uwv/core/mask.h"
#include "uwv/core/monitor.h"
#include "uwv/core/thread_pool.h"

namespace uwv {

/// What the camera did, as far as the pictures tell.
enum class ClipMotion {
  moving,         ///< Parallax enough for cameras and depth.
  turning,        ///< Rotation only (or zoom): poses are rotations about one point, depth cannot be measured.
  still,          ///< Locked off: every pose is the identity.
  indeterminate,  ///< Too little to track, or contradictory: no poses are given. `reason` says which.
};
std::string_view to_string(ClipMotion motion);

struct SfmOptions {
  /// The clip's intrinsics where they are known; empty = one focal length for all frames is estimated, with the centre
  /// of the picture as principal point.
  std::optional<Intrinsics> intrinsics;
  int max_features = 1500;    ///< Tracked at once. More: steadier cameras, time grows in proportion.
  int tracking_height = 480;  ///< Pictures taller than this are shrunk to it. Results are in full pixels; the
                              ///< two limits below count pixels of the tracked picture, as noise does.
  /// Of the median shift that rotation cannot explain, the largest over the clip's frame pairs. Below a quarter of this
  /// the camera is `turning`, above four times this `moving`. Between, where things that move by themselves or a weak
  /// lens could feign either, both are fitted, and `moving` must halve what turning leaves unexplained.
  double min_parallax_px = 2.0;
  double max_error_px = 2.0;  ///< An observation reprojecting farther off is an outlier.
  std::uint64_t seed = 1;     ///< Of the samples that relative poses and poses are drawn from. The same seed gives the
                              ///< same bytes with any number of threads.
  /// Throws std::invalid_argument when a value is out of range.
  void check() const;
};

/// A frame in which a scene point was seen, and where (pixels of the full picture, centres at +0.5).
struct PointObservation {
  int frame = 0;
  Eigen::Vector2d pixel;
};

/// A reconstructed, static scene point.
struct ScenePoint {
  Eigen::Vector3d x_in_world = Eigen::Vector3d::Zero();
  std::vector<PointObservation> observations;
  double error_px = 0;  ///< Root mean square reprojection error.
};

/// A given lens that the pictures contradict: another one leaves clearly less unexplained.
struct LensDoubt {
  double given_fov_deg = 0, seen_fov_deg = 0;    ///< Horizontal.
  double given_error_px = 0, seen_error_px = 0;  ///< Root mean square over some key frames, outliers cut off.
};

struct SfmResult {
  ClipMotion motion = ClipMotion::indeterminate;
  std::string reason;                    ///< One sentence: why this motion, in numbers.
  std::vector<Camera> cameras;           ///< One per frame unless indeterminate (then empty).
  std::vector<std::uint8_t> registered;  ///< Per frame: 1 = pose measured, 0 = interpolated between neighbours.
  std::vector<ScenePoint> points;        ///< Only for `moving`.
  /// Frames at which another shot begins. Everything here is about the longest shot.
  std::vector<int> cuts;
  /// Per frame: 1 = of that shot. 0 = of another one: not registered, and its camera is only a placeholder (the shot's
  /// nearest) that says nothing about the frame.
  std::vector<std::uint8_t> in_shot;
  bool focal_estimated = false;
  /// Set when `intrinsics` were given and cannot be those of the clip. They are used all the same: the caller may know
  /// what the pictures cannot tell. A caller who only guessed should leave them out.
  std::optional<LensDoubt> lens_doubt;
  std::vector<std::string> notes;  ///< What to tell the user, one sentence each; with `lens_doubt` one about it.
  double parallax_px = 0;          ///< Median over tracks of the shift rotation cannot explain.
  double rms_error_px = 0;         ///< Of all inlier observations.
  double moving_share = 0;         ///< Share of the tracks (three frames or more) that no static point explains:
                                   ///< moving things, but also tracks slipping along edges of depth.
  double seconds = 0;
  std::string brief() const;  ///< One line.
};

/// All frames have one size. Reports stages "tracking", "cameras", "bundle adjustment" to the monitor. Throws
/// std::invalid_argument for no frames or frames of different sizes; never for what the pictures show.
SfmResult structure_from_motion(std::span<const ImageRgb> frames, const SfmOptions& options, ThreadPool& pool,
                                Monitor& monitor);

}  // namespace uwv
