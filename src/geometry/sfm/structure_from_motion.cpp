// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/structure_from_motion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "geometry/sfm/reconstruction.h"
#include "geometry/sfm/two_view.h"

namespace uwv {
namespace {

using namespace sfm;

constexpr double assumed_fov = std::numbers::pi / 3;
constexpr double tried_fovs_deg[] = {60, 45, 80, 32};  // the usual first: later ones must be clearly better

Shot longest_shot(const std::vector<int>& cuts, int frames) {
  Shot longest{0, -1};
  int first = 0;
  for (std::size_t i = 0; i <= cuts.size(); ++i) {
    const int end = i < cuts.size() ? cuts[i] : frames;
    if (end - first > longest.frames()) longest = {first, end - 1};
    first = end;
  }
  return longest;
}

std::vector<double> focal_hypotheses(const SfmOptions& options, Size size) {
  if (options.intrinsics) return {options.intrinsics->fx};
  std::vector<double> focals;
  for (const double fov : tried_fovs_deg)
    focals.push_back(Intrinsics::from_fov_x(fov * std::numbers::pi / 180, size).fx);
  return focals;
}

Intrinsics with_focal(Intrinsics intrinsics, double fx) {
  intrinsics.fy *= fx / intrinsics.fx;
  intrinsics.fx = fx;
  return intrinsics;
}

/// The reconstruction of the key frames under the focal length that explains most, best.
std::optional<Reconstruction> best_reconstruction(const std::vector<Track>& tracks, const std::vector<int>& keys,
                                                  const Intrinsics& intrinsics, const std::vector<double>& focals,
                                                  const SfmOptions& options, int threads, Monitor& monitor) {
  std::optional<Reconstruction> best;
  double best_score = 0;
  for (const double focal : focals) {
    auto found = reconstruct(tracks, keys, with_focal(intrinsics, focal), focals.size() > 1, options, threads, monitor);
    if (!found) continue;
    const double score = static_cast<double>(found->observations) / (0.1 + found->rms_px);
    if (score > 1.05 * best_score) best_score = score, best = std::move(found);
  }
  return best;
}

Rigid3 between(const Rigid3& a, const Rigid3& b, double share) {
  const Eigen::Quaterniond qa(a.rotation), qb(b.rotation);
  return {qa.slerp(share, qb).toRotationMatrix(), (1 - share) * a.translation + share * b.translation};
}

/// One camera a frame; those that were not registered lie between their neighbours.
void place_cameras(const Model& model, const Rigid3& world_from_model, double unit, Size size, std::size_t frames,
                   SfmResult& result) {
  std::map<int, Rigid3> world_from_cam;
  for (const auto& [frame, cam_from_model] : model.cam_from_world) {
    Rigid3 pose = world_from_model * cam_from_model.inverse();
    pose.translation *= unit;
    world_from_cam[frame] = pose;
  }
  result.registered.assign(frames, 0);
  for (std::size_t i = 0; i < frames; ++i) {
    const int frame = static_cast<int>(i);
    const auto after = world_from_cam.lower_bound(frame);
    Rigid3 pose;
    if (after == world_from_cam.end())
      pose = std::prev(after)->second;
    else if (after->first == frame || after == world_from_cam.begin())
      pose = after->second;
    else
      pose = between(std::prev(after)->second, after->second,
                     static_cast<double>(frame - std::prev(after)->first) / (after->first - std::prev(after)->first));
    result.registered[i] = world_from_cam.contains(frame) ? 1 : 0;
    result.cameras.push_back({model.intrinsics, pose, size});
  }
}

void place_points(const Model& model, const std::vector<Track>& tracks, const Rigid3& world_from_model, double unit,
                  SfmResult& result) {
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    if (model.known[t] == 0) continue;
    ScenePoint point;
    point.x_in_world = unit * (world_from_model * model.points[t]);
    double squares = 0;
    for (const auto& [frame, pose] : model.cam_from_world) {
      if (!tracks[t].covers(frame)) continue;
      point.observations.push_back({frame, tracks[t].at(frame)});
      const double error = reprojection_error(model, tracks[t], t, frame);
      squares += error * error;
    }
    point.error_px = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, point.observations.size())));
    result.points.push_back(std::move(point));
  }
}

/// World = the first registered camera; unit = the median depth of what it sees.
void deliver(const Reconstruction& reconstruction, const std::vector<Track>& tracks, Size size, std::size_t frames,
             SfmResult& result) {
  const Model& model = reconstruction.model;
  const auto& [first, first_from_model] = *model.cam_from_world.begin();
  std::vector<double> depths, all_depths;
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    if (model.known[t] == 0) continue;
    const double depth = (first_from_model * model.points[t]).z();
    all_depths.push_back(depth);
    if (tracks[t].covers(first)) depths.push_back(depth);
  }
  const double typical = median(depths.empty() ? all_depths : depths);
  const double unit = typical > 0 ? 1 / typical : 1;
  place_cameras(model, first_from_model, unit, size, frames, result);
  place_points(model, tracks, first_from_model, unit, result);
  result.rms_error_px = reconstruction.rms_px;
  std::size_t long_tracks = 0, placed = 0;
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    constexpr std::size_t long_enough = 6;
    if (tracks[t].pixels.size() < long_enough || tracks[t].first < first) continue;
    ++long_tracks;
    placed += model.known[t];
  }
  result.moving_share = long_tracks == 0 ? 0 : 1 - static_cast<double>(placed) / static_cast<double>(long_tracks);
}

/// Rotations about one point, each frame against the one before it that shares most.
void turn_cameras(const std::vector<Track>& tracks, const Shot& shot, const Intrinsics& intrinsics, Size size,
                  std::size_t frames, std::uint64_t seed, SfmResult& result) {
  std::vector<Eigen::Matrix3d> cam_from_first(frames, Eigen::Matrix3d::Identity());
  result.registered.assign(frames, 0);
  int anchor = shot.first;
  for (int i = shot.first; i <= shot.last; ++i) {
    const auto at = static_cast<std::size_t>(i);
    result.registered[at] = 1;
    constexpr std::size_t enough = 60;  // below, a nearer frame is the better start
    std::vector<Pair> pairs = common_tracks(tracks, anchor, i);
    if (pairs.size() < enough && i > shot.first) anchor = i - 1, pairs = common_tracks(tracks, anchor, i);
    if (i > shot.first)
      cam_from_first[at] =
          fit_rotation(pairs, intrinsics, seed).b_from_a * cam_from_first[static_cast<std::size_t>(anchor)];
  }
  for (std::size_t i = 0; i < frames; ++i) {
    const auto at = static_cast<std::size_t>(std::clamp(static_cast<int>(i), shot.first, shot.last));
    result.cameras.push_back({intrinsics, {cam_from_first[at].transpose(), Eigen::Vector3d::Zero()}, size});
  }
}

void check_frames(std::span<const ImageRgb> frames) {
  require(!frames.empty(), "structure_from_motion: found no frames, wanted at least one");
  for (const ImageRgb& frame : frames)
    require(frame.size() == frames.front().size() && !frame.empty(),
            "structure_from_motion: found frames of {}x{} and {}x{}", frames.front().width(), frames.front().height(),
            frame.width(), frame.height());
}

class Solver {
 public:
  Solver(std::span<const ImageRgb> frames, const SfmOptions& options, ThreadPool& pool, Monitor& monitor)
      : frames_(frames), options_(options), size_(frames.front().size()), pool_(pool), monitor_(monitor) {}

  SfmResult solve() {
    const Tracks found = follow_features(frames_, options_, pool_, monitor_);
    result_.cuts = found.cuts;
    shot_ = longest_shot(found.cuts, static_cast<int>(frames_.size()));
    intrinsics_ = options_.intrinsics.value_or(Intrinsics::from_fov_x(assumed_fov, size_));
    const std::vector<double> focals = focal_hypotheses(options_, size_);
    const MotionKind kind = kind_of_motion(found.tracks, shot_, intrinsics_, focals, options_);
    result_.motion = kind.motion;
    result_.reason = kind.reason;
    result_.parallax_px = kind.parallax_px;
    switch (kind.motion) {
      case ClipMotion::still: stand(); break;
      case ClipMotion::turning: turn(found.tracks, kind); break;
      case ClipMotion::moving: move(found, focals); break;
      case ClipMotion::indeterminate: break;
    }
    return std::move(result_);
  }

 private:
  void stand() {
    result_.registered.assign(frames_.size(), 0);
    for (int i = shot_.first; i <= shot_.last; ++i) result_.registered[static_cast<std::size_t>(i)] = 1;
    result_.cameras.assign(frames_.size(), {intrinsics_, {}, size_});
  }

  void turn(const std::vector<Track>& tracks, const MotionKind& kind) {
    if (kind.focal > 0 && !options_.intrinsics) {
      intrinsics_ = with_focal(intrinsics_, kind.focal);
      result_.focal_estimated = true;
    }
    turn_cameras(tracks, shot_, intrinsics_, size_, frames_.size(), options_.seed, result_);
  }

  void move(const Tracks& found, const std::vector<double>& focals) {
    const std::vector<int> keys = key_frames(found.shift_px, shot_, size_.width);
    auto best = best_reconstruction(found.tracks, keys, intrinsics_, focals, options_, pool_.size(), monitor_);
    const auto wanted = std::max<std::size_t>(2, keys.size() / 2);
    if (!best || best->model.cam_from_world.size() < wanted) {
      result_.motion = ClipMotion::indeterminate;
      result_.reason = fmt::format("{}, yet only {} of {} key frames fit together: too little to follow, or most of it "
                                   "moves by itself",
                                   result_.reason, best ? best->model.cam_from_world.size() : 0, keys.size());
      return;
    }
    register_rest(found.tracks, shot_, focals.size() > 1, options_, pool_.size(), monitor_, *best);
    result_.focal_estimated = focals.size() > 1;
    deliver(*best, found.tracks, size_, frames_.size(), result_);
  }

  std::span<const ImageRgb> frames_;
  const SfmOptions& options_;
  Size size_;
  ThreadPool& pool_;
  Monitor& monitor_;
  Shot shot_;
  Intrinsics intrinsics_;
  SfmResult result_;
};

}  // namespace

SfmResult structure_from_motion(std::span<const ImageRgb> frames, const SfmOptions& options, ThreadPool& pool,
                                Monitor& monitor) {
  options.check();
  check_frames(frames);
  const auto start = std::chrono::steady_clock::now();
  SfmResult result = Solver(frames, options, pool, monitor).solve();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace uwv
