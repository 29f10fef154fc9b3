// SPDX-License-Identifier: Apache-2.0
// What the tracks say about the camera before any reconstruction: does anything move, and can turning explain it?
#pragma once

#include <span>

#include "geometry/sfm/tracks.h"
#include "uwv/core/camera.h"

namespace uwv::sfm {

/// The rotation b_from_a that best turns the matches' rays into each other, against outliers of up to about half.
Eigen::Matrix3d fit_rotation(const PairMatches& matches, const Intrinsics& lens);
/// Per match, how far from b the turned a lands, in pixels.
std::vector<double> rotation_residuals(const PairMatches& matches, const Intrinsics& lens,
                                       const Eigen::Matrix3d& b_from_a);

/// Median over the tracks of how far each strays from its own first place, in pixels. Tracks of `least` frames or more.
double median_travel(const std::vector<Track>& tracks, int least);

/// Tracks of `least` frames or more that never leave their place by `limit_px`.
struct Standing {
  double share = 0;   ///< Of those tracks.
  double spread = 0;  ///< Share of the parts of the picture (4x4) with such tracks where a quarter of them stands.
};
Standing standing_tracks(const std::vector<Track>& tracks, int least, double limit_px, Size size);

/// Frames some way apart, chosen so that at least one of them spans each stretch of the shot.
struct FramePair {
  int a = 0, b = 0;
};
/// Keyframes: a new one whenever the picture has shifted by `step_px` (median) or half of the tracks were lost.
std::vector<int> choose_keyframes(const std::vector<Track>& tracks, int frames, double step_px);
std::vector<FramePair> pairs_of(const std::vector<Track>& tracks, std::span<const int> keyframes, int least_matches);

struct TurningFit {
  Intrinsics lens;         ///< As given, or the candidate that leaves least.
  double parallax_px = 0;  ///< Largest over the pairs of the median residual after the best rotation.
};
/// How much of the pairs' motion remains after rotation; the smallest over the candidate lenses.
TurningFit fit_turning(const std::vector<Track>& tracks, std::span<const FramePair> pairs,
                       std::span<const Intrinsics> lenses);
/// The same over focal lengths near the fit's own.
TurningFit refine_turning(const std::vector<Track>& tracks, std::span<const FramePair> pairs, TurningFit fit);

}  // namespace uwv::sfm
