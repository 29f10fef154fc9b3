// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/structure_from_motion.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "geometry/sfm/feature_tracking.h"
#include "geometry/sfm/hypotheses.h"
#include "geometry/sfm/motion_kind.h"
#include "geometry/sfm/result.h"
#include "geometry/sfm/turning.h"

namespace uwv {
namespace {

using namespace sfm;

constexpr int least_matches = 20;        // fewer say nothing reliable about two frames
constexpr double still_px = 0.75;        // tracks of a locked-off camera stray by less, compression included
constexpr double assumed_fov_degrees = 60;

Intrinsics lens_of_fov(double degrees, Size size) {
  return Intrinsics::from_fov_x(degrees * std::numbers::pi / 180, size);
}

std::vector<Intrinsics> candidate_lenses(const SfmOptions& options, Size full, Size tracked,
                                         std::initializer_list<double> fovs) {
  if (options.intrinsics) return {options.intrinsics->resized(full, tracked)};
  std::vector<Intrinsics> out;
  for (const double fov : fovs) out.push_back(lens_of_fov(fov, tracked));
  return out;
}

struct Shot {
  int begin = 0, end = 0;
  int length() const { return end - begin; }
};

Shot longest_shot(const TrackedClip& clip) {
  Shot best, now;
  for (std::size_t i = 0; i <= clip.cuts.size(); ++i) {
    now.end = i < clip.cuts.size() ? clip.cuts[i] : clip.frames;
    if (now.length() > best.length()) best = now;
    now.begin = now.end;
  }
  return best;
}

/// Matches between neighbouring frames in the poorest tenth of the shot.
int typical_matches(const std::vector<Track>& tracks, int frames) {
  std::vector<int> counts(static_cast<std::size_t>(frames - 1), 0);
  for (const Track& track : tracks)
    for (int f = track.first; f + 1 < track.end(); ++f) ++counts[static_cast<std::size_t>(f)];
  std::sort(counts.begin(), counts.end());
  return counts[counts.size() / 10];
}

double travel_of(const std::vector<Track>& tracks, int frames) {
  const int least = std::min(frames, 10);
  const auto lasting = std::count_if(tracks.begin(), tracks.end(),
                                     [&](const Track& t) { return static_cast<int>(t.pixels.size()) >= least; });
  return median_travel(tracks, lasting >= least_matches ? least : 2);
}

/// Dense enough for parallax to be followed, at most 40 so that trials stay cheap.
std::vector<int> keyframes_of(const std::vector<Track>& tracks, int frames, Size size) {
  double step = std::max(4.0, 0.02 * size.width);
  std::vector<int> out = choose_keyframes(tracks, frames, step);
  for (int i = 0; i < 8 && out.size() > 40; ++i) out = choose_keyframes(tracks, frames, step *= 1.4);
  return out;
}

/// The job's parts: what the clip is, then what follows from it.
class Job {
 public:
  Job(std::span<const ImageRgb> frames, const SfmOptions& options, ThreadPool& pool, Monitor& monitor)
      : options_(options), monitor_(monitor), full_(frames.front().size()) {
    clip_ = track_features(frames, options, pool, monitor);
    shot_ = longest_shot(clip_);
    tracks_ = tracks_of_shot(clip_, shot_.begin, shot_.end);
  }

  SfmResult result() {
    result_.cuts = clip_.cuts;
    result_.focal_estimated = false;
    if (shot_.length() < 2) return still("no frame has a neighbour of the same shot, so nothing can have moved");
    const int matches = typical_matches(tracks_, shot_.length());
    if (matches < least_matches)
      return indeterminate(fmt::format("only {} features could be followed between frames; {} are needed", matches,
                                       least_matches));
    const double travel = travel_of(tracks_, shot_.length());
    if (travel < still_px)
      return still(fmt::format("half of the tracks stay within {:.2f} px of where they began", travel));
    const std::vector<int> keyframes = keyframes_of(tracks_, shot_.length(), clip_.size);
    const std::vector<FramePair> pairs = pairs_of(tracks_, keyframes, least_matches);
    if (pairs.empty()) return indeterminate("no two frames apart share enough tracks");
    const TurningFit turning = fit_turning(
        tracks_, pairs, candidate_lenses(options_, full_, clip_.size, {25, 35, 45, 55, 65, 80, 100, 120}));
    result_.parallax_px = turning.parallax_px * scale();
    if (turning.parallax_px < options_.min_parallax_px) return turned(turning);
    return moved(keyframes, pairs);
  }

 private:
  double scale() const { return static_cast<double>(full_.width) / clip_.size.width; }

  Intrinsics assumed_lens() const {
    return options_.intrinsics ? *options_.intrinsics : lens_of_fov(assumed_fov_degrees, full_);
  }

  SfmResult indeterminate(std::string reason) {
    result_.motion = CameraMotion::indeterminate;
    result_.reason = std::move(reason);
    result_.registered.assign(static_cast<std::size_t>(clip_.frames), 0);
    return std::move(result_);
  }

  SfmResult still(std::string reason) {
    result_.motion = CameraMotion::still;
    result_.reason = std::move(reason);
    if (!options_.intrinsics) result_.reason += "; the lens is assumed";
    result_.cameras.assign(static_cast<std::size_t>(clip_.frames), Camera{assumed_lens(), Rigid3{}, full_});
    result_.registered.assign(static_cast<std::size_t>(clip_.frames), 0);
    std::fill(result_.registered.begin() + shot_.begin, result_.registered.begin() + shot_.end, std::uint8_t{1});
    return std::move(result_);
  }

  GrowOptions grow_options(const Intrinsics& prior) const {
    return {options_.max_error_px, !options_.intrinsics, prior.fx};
  }

  SfmResult turned(const TurningFit& fit) {
    std::vector<int> all(static_cast<std::size_t>(shot_.length()));
    for (int f = 0; f < shot_.length(); ++f) all[static_cast<std::size_t>(f)] = f;
    const std::vector<Track> some = thinned(tracks_, all, 200);
    monitor_.step("cameras", 0, 1);
    const Reconstruction rotations = turn(some, shot_.length(), fit.lens, grow_options(fit.lens));
    result_.motion = CameraMotion::turning;
    result_.focal_estimated = !options_.intrinsics;
    result_.reason = fmt::format("rotation leaves {:.2f} px of the motion unexplained, less than {:.2f}",
                                 result_.parallax_px, options_.min_parallax_px * scale());
    fill_cameras(result_, rotations, {shot_.begin, clip_.frames, full_, clip_.size});
    fill_errors(result_, rotations, some, options_.max_error_px, scale());
    return std::move(result_);
  }

  SfmResult moved(const std::vector<int>& keyframes, const std::vector<FramePair>& pairs) {
    std::vector<int> all(static_cast<std::size_t>(shot_.length()));
    for (int f = 0; f < shot_.length(); ++f) all[static_cast<std::size_t>(f)] = f;
    const std::vector<Track> some = thinned(tracks_, all, 600);
    Exploration exploration;
    exploration.lenses = candidate_lenses(options_, full_, clip_.size, {60, 40, 85, 110, 25});
    exploration.grow = grow_options(lens_of_fov(assumed_fov_degrees, clip_.size));
    exploration.size = clip_.size;
    const Outcome outcome = reconstruct(some, shot_.length(), keyframes, pairs, exploration, monitor_);
    const double limit = options_.max_error_px;
    if (!outcome.found || outcome.misfit > 0.7 * limit * limit)
      return indeterminate(fmt::format(
          "tracks move, but no {} camera path explains them: {} beginnings tried, best residual {:.2f} of {:.2f} px",
          options_.intrinsics ? "(with the given lens)" : "", outcome.tried, std::sqrt(outcome.misfit), limit));
    const auto posed = static_cast<int>(outcome.reconstruction.registered().size());
    if (2 * posed < shot_.length())
      return indeterminate(fmt::format("only {} of {} frames could be placed", posed, shot_.length()));
    result_.motion = CameraMotion::moving;
    result_.focal_estimated = !options_.intrinsics;
    fill_cameras(result_, outcome.reconstruction, {shot_.begin, clip_.frames, full_, clip_.size});
    fill_errors(result_, outcome.reconstruction, some, limit, scale());
    fill_points(result_, outcome.reconstruction, some, limit, {shot_.begin, clip_.frames, full_, clip_.size});
    result_.reason = fmt::format("{:.1f} px of parallax; {} of {} frames placed, {} points, error {:.2f} px{}",
                                 result_.parallax_px, posed, shot_.length(), result_.points.size(),
                                 result_.rms_error_px,
                                 outcome.from_plane ? "; nearly one plane is seen, its homography began" : "");
    return std::move(result_);
  }

  const SfmOptions& options_;
  Monitor& monitor_;
  Size full_;
  TrackedClip clip_;
  Shot shot_;
  std::vector<Track> tracks_;
  SfmResult result_;
};

}  // namespace

std::string_view to_string(CameraMotion motion) {
  switch (motion) {
    case CameraMotion::moving: return "moving";
    case CameraMotion::turning: return "turning";
    case CameraMotion::still: return "still";
    default: return "indeterminate";
  }
}

void SfmOptions::check() const {
  require(max_features >= 50 && max_features <= 100000, "max_features {} is not in 50..100000", max_features);
  require(tracking_height >= 60, "tracking_height {} is below 60", tracking_height);
  require(min_parallax_px > 0 && std::isfinite(min_parallax_px), "min_parallax_px {} is not positive", min_parallax_px);
  require(max_error_px > 0 && std::isfinite(max_error_px), "max_error_px {} is not positive", max_error_px);
  if (!intrinsics) return;
  require(std::isfinite(intrinsics->fx) && std::isfinite(intrinsics->fy) && intrinsics->fx > 0 && intrinsics->fy > 0,
          "the focal length {} x {} is not positive", intrinsics->fx, intrinsics->fy);
  require(std::isfinite(intrinsics->cx) && std::isfinite(intrinsics->cy), "the principal point is not finite");
}

std::string SfmResult::brief() const {
  return fmt::format("{}: {} ({} cuts, {:.0f} % of the tracks move by themselves, {:.1f} s)", to_string(motion), reason,
                     cuts.size(), 100 * moving_share, seconds);
}

SfmResult structure_from_motion(std::span<const ImageRgb> frames, const SfmOptions& options, ThreadPool& pool,
                                Monitor& monitor) {
  options.check();
  require(!frames.empty(), "structure from motion needs at least one frame");
  for (const ImageRgb& frame : frames)
    require(!frame.empty() && frame.size() == frames.front().size(), "a frame of {}x{} among frames of {}x{}",
            frame.width(), frame.height(), frames.front().width(), frames.front().height());
  const auto start = std::chrono::steady_clock::now();
  SfmResult result = Job(frames, options, pool, monitor).result();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace uwv
