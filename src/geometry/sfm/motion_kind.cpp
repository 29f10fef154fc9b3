// SPDX-License-Identifier: Apache-2.0
#include "geometry/sfm/motion_kind.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace uwv::sfm {
namespace {

/// Kabsch: the rotation that maximises the weighted sum of b . R a.
Eigen::Matrix3d weighted_rotation(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b,
                                  const std::vector<double>& weights) {
  Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < a.size(); ++i) m += weights[i] * b[i] * a[i].transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1.0 : 1.0);
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

/// The largest median residual of the pairs; once it reaches `enough`, the rest are not looked at.
double turning_leaves(const std::vector<Track>& tracks, std::span<const FramePair> pairs, const Intrinsics& lens,
                      double enough) {
  double worst = 0;
  for (const FramePair& pair : pairs) {
    const PairMatches matches = matches_between(tracks, pair.a, pair.b);
    // A false lens may put what is turned behind the camera; not to turn at all is a rotation through any lens.
    const double unturned = median(rotation_residuals(matches, lens, Eigen::Matrix3d::Identity()));
    worst = std::max(worst, std::min(unturned, median(rotation_residuals(matches, lens, fit_rotation(matches, lens)))));
    if (worst >= enough) break;
  }
  return worst;
}

}  // namespace

Eigen::Matrix3d fit_rotation(const PairMatches& matches, const Intrinsics& lens) {
  std::vector<Eigen::Vector3d> a, b;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    a.push_back(unproject(lens, matches.a[i], 1).normalized());
    b.push_back(unproject(lens, matches.b[i], 1).normalized());
  }
  std::vector<double> weights(a.size(), 1);
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  for (int round = 0; round < 12; ++round) {
    rotation = weighted_rotation(a, b, weights);
    const std::vector<double> residuals = rotation_residuals(matches, lens, rotation);
    // Cauchy weights whose scale follows the median down: the majority decides.
    const double scale = std::max(0.3, median(residuals));
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const double r = residuals[i] / scale;
      weights[i] = 1 / (1 + r * r);
    }
  }
  return rotation;
}

std::vector<double> rotation_residuals(const PairMatches& matches, const Intrinsics& lens,
                                       const Eigen::Matrix3d& b_from_a) {
  std::vector<double> out;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    Eigen::Vector2d pixel;
    const bool front = project(lens, b_from_a * unproject(lens, matches.a[i], 1), pixel);
    out.push_back(front ? (pixel - matches.b[i]).norm() : 1e4);
  }
  return out;
}

double median_travel(const std::vector<Track>& tracks, int least) {
  std::vector<double> travel;
  for (const Track& track : tracks) {
    if (static_cast<int>(track.pixels.size()) < least) continue;
    double farthest = 0;
    for (const Eigen::Vector2d& p : track.pixels) farthest = std::max(farthest, (p - track.pixels.front()).norm());
    travel.push_back(farthest);
  }
  return median(travel);
}

Standing standing_tracks(const std::vector<Track>& tracks, int least, double limit_px, Size size) {
  constexpr int parts = 4;
  std::array<int, parts * parts> lasting{}, standing{};
  for (const Track& track : tracks) {
    if (static_cast<int>(track.pixels.size()) < least) continue;
    const Eigen::Vector2d& start = track.pixels.front();
    const int column = std::clamp(static_cast<int>(start.x() * parts / size.width), 0, parts - 1);
    const int row = std::clamp(static_cast<int>(start.y() * parts / size.height), 0, parts - 1);
    const auto part = static_cast<std::size_t>(row * parts + column);
    ++lasting[part];
    standing[part] += std::all_of(track.pixels.begin(), track.pixels.end(),
                                  [&](const Eigen::Vector2d& p) { return (p - start).norm() < limit_px; });
  }
  const int all = std::accumulate(lasting.begin(), lasting.end(), 0);
  if (all == 0) return {};
  int occupied = 0, holding = 0;
  for (std::size_t i = 0; i < lasting.size(); ++i) {
    occupied += lasting[i] > 0;
    holding += lasting[i] > 0 && 4 * standing[i] >= lasting[i];
  }
  return {static_cast<double>(std::accumulate(standing.begin(), standing.end(), 0)) / all,
          static_cast<double>(holding) / occupied};
}

std::vector<int> choose_keyframes(const std::vector<Track>& tracks, int frames, double step_px) {
  std::vector<int> out{0};
  const auto in_frame = [&](int frame) {
    return std::count_if(tracks.begin(), tracks.end(), [&](const Track& t) { return t.in(frame); });
  };
  auto held = in_frame(0);
  for (int f = 1; f < frames; ++f) {
    const PairMatches matches = matches_between(tracks, out.back(), f);
    std::vector<double> shift;
    for (std::size_t i = 0; i < matches.size(); ++i) shift.push_back((matches.a[i] - matches.b[i]).norm());
    if (median(shift) < step_px && 2 * static_cast<long>(matches.size()) > held && f + 1 < frames) continue;
    out.push_back(f);
    held = in_frame(f);
  }
  return out;
}

std::vector<FramePair> pairs_of(const std::vector<Track>& tracks, std::span<const int> keyframes, int least_matches) {
  std::vector<FramePair> out;
  const auto n = keyframes.size();
  for (std::size_t gap = 1; gap < n; gap *= 2)
    for (std::size_t i = 0; i + gap < n; i += std::max<std::size_t>(1, gap / 2)) {
      const FramePair pair{keyframes[i], keyframes[i + gap]};
      if (static_cast<int>(matches_between(tracks, pair.a, pair.b).size()) >= least_matches) out.push_back(pair);
    }
  return out;
}

TurningFit fit_turning(const std::vector<Track>& tracks, std::span<const FramePair> pairs,
                       std::span<const Intrinsics> lenses) {
  TurningFit best{lenses.front(), std::numeric_limits<double>::infinity()};
  for (const Intrinsics& lens : lenses) {
    const double left = turning_leaves(tracks, pairs, lens, best.parallax_px);
    if (left < best.parallax_px) best = {lens, left};
  }
  return best;
}

TurningFit refine_turning(const std::vector<Track>& tracks, std::span<const FramePair> pairs, TurningFit fit) {
  for (const double step : {1.12, 1.06, 1.03, 1.015}) {
    const Intrinsics middle = fit.lens;
    for (const double factor : {step, 1 / step}) {
      Intrinsics lens = middle;
      lens.fx *= factor;
      lens.fy *= factor;
      const double left = turning_leaves(tracks, pairs, lens, fit.parallax_px);
      if (left < fit.parallax_px) fit = {lens, left};
    }
  }
  return fit;
}

}  // namespace uwv::sfm
