// SPDX-License-Identifier: Apache-2.0
#include "geometry/sfm/motion_kind.h"

#include <algorithm>

#include "geometry/sfm/two_view.h"

namespace uwv::sfm {
namespace {

constexpr std::size_t enough_tracks = 30;
constexpr double still_px = 0.75;      // tracking noise on compressed video
constexpr double still_share = 0.5;    // of the tracks: what fills half the picture and does not move is the world

/// Pairs of frames far enough apart to tell, near enough to share tracks.
std::vector<std::pair<int, int>> telling_pairs(const std::vector<Track>& tracks, const Shot& shot) {
  std::vector<std::pair<int, int>> pairs;
  const int starts = 4;
  for (int s = 0; s < starts; ++s) {
    const int a = shot.first + s * (shot.frames() - 1) / starts;
    int b = shot.last;
    while (b > a && common_tracks(tracks, a, b).size() < 2 * enough_tracks) b = a + (b - a) / 2;
    if (b > a && common_tracks(tracks, a, b).size() >= enough_tracks) pairs.emplace_back(a, b);
  }
  return pairs;
}

struct PairEvidence {
  double still = 1;        ///< Share of tracks that did not move.
  double shift_px = 0;     ///< Median shift.
  double residual_px = 0;  ///< Of the best rotation at the best focal length.
  double focal = 0;
};

PairEvidence evidence(const std::vector<Pair>& pairs, Intrinsics k, const std::vector<double>& focals,
                      std::uint64_t seed) {
  PairEvidence found;
  const auto still = std::count_if(pairs.begin(), pairs.end(),
                                   [](const Pair& p) { return (p.a - p.b).norm() < still_px; });
  found.still = static_cast<double>(still) / static_cast<double>(pairs.size());
  std::vector<double> shifts;
  for (const Pair& pair : pairs) shifts.push_back((pair.a - pair.b).norm());
  found.shift_px = median(std::move(shifts));
  found.residual_px = 1e9;
  const double aspect = k.fy / k.fx;
  for (const double focal : focals) {
    k.fx = focal;
    k.fy = focal * aspect;
    const RotationFit fit = fit_rotation(pairs, k, seed);
    if (fit.residual_px < found.residual_px) found.residual_px = fit.residual_px, found.focal = focal;
  }
  return found;
}

}  // namespace

MotionKind kind_of_motion(const std::vector<Track>& tracks, const Shot& shot, const Intrinsics& intrinsics,
                          const std::vector<double>& focals, const SfmOptions& options) {
  MotionKind kind;
  if (shot.frames() == 1) {
    kind.motion = ClipMotion::still;
    kind.reason = "one frame shows no motion";
    return kind;
  }
  const auto pairs = telling_pairs(tracks, shot);
  if (pairs.empty()) {
    kind.reason = fmt::format("fewer than {} points can be followed through the clip", enough_tracks);
    return kind;
  }
  double least_still = 1;
  bool all_still = true;
  for (const auto& [a, b] : pairs) {
    const PairEvidence found = evidence(common_tracks(tracks, a, b), intrinsics, focals, options.seed);
    least_still = std::min(least_still, found.still);
    // Grass in the wind moves every point a little; a rotation that explains hardly more than none is none.
    const bool nothing_to_explain =
        found.shift_px < options.min_parallax_px && found.shift_px < 1.5 * std::max(found.residual_px, still_px);
    const bool still = found.still >= still_share || nothing_to_explain;
    all_still &= still;
    if (still || found.residual_px <= kind.parallax_px) continue;
    kind.parallax_px = found.residual_px;
    kind.focal = found.focal;
  }
  if (all_still) {
    kind.motion = ClipMotion::still;
    kind.parallax_px = 0;
    kind.reason = fmt::format("at least {:.0f} % of the points stay within {} px, and no turn explains the others",
                              100 * least_still, still_px);
  } else if (kind.parallax_px < options.min_parallax_px) {
    kind.motion = ClipMotion::turning;
    kind.reason = fmt::format("a turning camera explains the points to {:.2f} px, and {} px of parallax are wanted",
                              kind.parallax_px, options.min_parallax_px);
  } else {
    kind.motion = ClipMotion::moving;
    kind.reason = fmt::format("no turning camera explains {:.1f} px of shift", kind.parallax_px);
  }
  return kind;
}

}  // namespace uwv::sfm
