// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/structure_from_motion.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <numeric>

#include "geometry/sfm/feature_tracking.h"
#include "geometry/sfm/hypotheses.h"
#include "geometry/sfm/lens_check.h"
#include "geometry/sfm/motion_kind.h"
#include "geometry/sfm/resection.h"
#include "geometry/sfm/result.h"
#include "geometry/sfm/track_refinement.h"
#include "geometry/sfm/triangulation.h"
#include "geometry/sfm/turning.h"

namespace uwv {
namespace {

using namespace sfm;

constexpr int least_matches = 20;        // fewer say nothing reliable about two frames
constexpr int adjusted_per_frame = 300;  // long tracks; more raise the time of adjustment, hardly its accuracy
constexpr int tried_per_frame = 200;     // the same while beginnings are compared
constexpr int least_supported = 12;      // frames on which beginnings are compared, where there are so many
constexpr int adjusted_frames = 24;      // at least; the others are placed by the adjusted points, as precisely
constexpr double still_px = 0.75;        // tracks of a locked-off camera stray by less, compression included
// A moving camera leaves next to nothing in its place: only what is drawn over the picture, or travels along.
constexpr double standing_share = 0.25, standing_spread = 0.5;
constexpr double clear_share = 0.25;  // of min_parallax_px: below, rotation explains all but noise
constexpr double clear_multiple = 4;  // of min_parallax_px: above, even things that move by themselves are no excuse
constexpr double convincing_share = 0.5;  // between, a moving camera must halve turning's misfit to be believed
constexpr double assumed_fov_degrees = 60;

Intrinsics lens_of_fov(double degrees, Size size) {
  return Intrinsics::from_fov_x(degrees * std::numbers::pi / 180, size);
}

std::vector<Intrinsics> lenses_of_fovs(std::initializer_list<double> fovs, Size size) {
  std::vector<Intrinsics> out;
  for (const double fov : fovs) out.push_back(lens_of_fov(fov, size));
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

/// The key frames and as many evenly spread ones as make up `least`: a slow camera has few key frames, and each
/// averages the noise of the others.
std::vector<int> supported(std::vector<int> keyframes, int frames, int least) {
  if (static_cast<int>(keyframes.size()) >= least) return keyframes;
  const int count = std::min(frames, least);
  for (int i = 0; i < count; ++i) keyframes.push_back(count > 1 ? i * (frames - 1) / (count - 1) : 0);
  std::sort(keyframes.begin(), keyframes.end());
  keyframes.erase(std::unique(keyframes.begin(), keyframes.end()), keyframes.end());
  return keyframes;
}

/// The job's parts: what the clip is, then what follows from it.
class Job {
 public:
  Job(std::span<const ImageRgb> frames, const SfmOptions& options, ThreadPool& pool, Monitor& monitor)
      : frames_(frames), options_(options), pool_(pool), monitor_(monitor), full_(frames.front().size()) {
    clip_ = track_features(frames, options, pool, monitor);
    shot_ = longest_shot(clip_);
    tracks_ = tracks_of_shot(clip_, shot_.begin, shot_.end);
    use_tracks();
  }

  SfmResult result() {
    result_.cuts = clip_.cuts;
    result_.in_shot.assign(static_cast<std::size_t>(clip_.frames), 0);
    std::fill(result_.in_shot.begin() + shot_.begin, result_.in_shot.begin() + shot_.end, std::uint8_t{1});
    result_.focal_estimated = false;
    if (shot_.length() < 2) return still("no frame has a neighbour of the same shot, so nothing can have moved");
    const int matches = typical_matches(tracks_, shot_.length());
    if (matches < least_matches)
      return indeterminate(
          fmt::format("only {} features could be followed between frames; {} are needed", matches, least_matches));
    const double travel = travel_of(tracks_, shot_.length());
    if (travel < still_px)
      return still(fmt::format("half of the tracks stay within {:.2f} px of where they began", travel));
    const Standing standing = standing_tracks(tracks_, std::min(shot_.length(), 10), still_px / 2, clip_.size);
    if (standing.share > standing_share && standing.spread > standing_spread)
      return still(
          fmt::format("{:.0f} % of the tracks, in {:.0f} % of the picture, do not move; the others move by "
                      "themselves",
                      100 * standing.share, 100 * standing.spread));
    const std::vector<int> keyframes = keyframes_of(tracks_, shot_.length(), clip_.size);
    const std::vector<FramePair> pairs = pairs_of(tracks_, keyframes, least_matches);
    if (pairs.empty()) return indeterminate("no two frames apart share enough tracks");
    const TurningFit turning = fit_turning_of(pairs);
    result_.parallax_px = turning.parallax_px * scale();
    if (turning.parallax_px < clear_share * options_.min_parallax_px) return turned(rotations_of(turning));
    const Outcome outcome = explore(supported(keyframes, shot_.length(), least_supported), pairs);
    if (turning.parallax_px < clear_multiple * options_.min_parallax_px) {
      const Reconstruction rotations = rotations_of(turning);
      const double limit = options_.max_error_px;
      if (!outcome.found || misfit(outcome.reconstruction, used_, keyframes, limit) >
                                convincing_share * misfit(rotations, used_, keyframes, limit))
        return turned(rotations);
    }
    return moved(outcome);
  }

 private:
  void use_tracks() {
    std::vector<int> all(static_cast<std::size_t>(shot_.length()));
    std::iota(all.begin(), all.end(), 0);
    used_ = thinned(tracks_, all, adjusted_per_frame);
  }

  std::span<const ImageRgb> shot_frames() const {
    return frames_.subspan(static_cast<std::size_t>(shot_.begin), static_cast<std::size_t>(shot_.length()));
  }

  double scale() const { return static_cast<double>(full_.width) / clip_.size.width; }

  Intrinsics assumed_lens() const {
    return options_.intrinsics ? *options_.intrinsics : lens_of_fov(assumed_fov_degrees, full_);
  }

  SfmResult indeterminate(std::string reason) {
    result_.motion = ClipMotion::indeterminate;
    result_.reason = std::move(reason);
    result_.registered.assign(static_cast<std::size_t>(clip_.frames), 0);
    return std::move(result_);
  }

  SfmResult still(std::string reason) {
    result_.motion = ClipMotion::still;
    result_.reason = std::move(reason);
    if (!options_.intrinsics) result_.reason += "; the lens is assumed";
    result_.cameras.assign(static_cast<std::size_t>(clip_.frames), Camera{assumed_lens(), Rigid3{}, full_});
    result_.registered.assign(static_cast<std::size_t>(clip_.frames), 0);
    std::fill(result_.registered.begin() + shot_.begin, result_.registered.begin() + shot_.end, std::uint8_t{1});
    return std::move(result_);
  }

  GrowOptions grow_options(bool refine_focal) const {
    return {options_.max_error_px, refine_focal, lens_of_fov(assumed_fov_degrees, clip_.size).fx, options_.seed};
  }

  /// Errors are told in pixels of the full picture, as all of the result's.
  void doubt_lens(std::optional<LensDoubt> doubt) {
    if (!doubt || result_.lens_doubt) return;
    doubt->given_error_px *= scale();
    doubt->seen_error_px *= scale();
    result_.lens_doubt = doubt;
    result_.notes.push_back(sentence_of(*doubt));
  }

  /// Whether turning explains the motion depends on the lens: a false one leaves what looks like parallax.
  TurningFit fit_turning_of(const std::vector<FramePair>& pairs) {
    const std::vector<Intrinsics> lenses = lenses_of_fovs({25, 35, 45, 55, 65, 80, 100, 120}, clip_.size);
    const TurningFit free = refine_turning(tracks_, pairs, fit_turning(tracks_, pairs, lenses));
    if (!options_.intrinsics) return free;
    const Intrinsics given = options_.intrinsics->resized(full_, clip_.size);
    const TurningFit fit = fit_turning(tracks_, pairs, std::vector<Intrinsics>{given});
    if (free.parallax_px < clear_share * options_.min_parallax_px)
      doubt_lens(doubt_of(LensFit{given, fit.parallax_px}, LensFit{free.lens, free.parallax_px}, clip_.size));
    return fit;
  }

  Reconstruction rotations_of(const TurningFit& fit) {
    monitor_.step("cameras", 0, 1);
    GrowOptions options = grow_options(!options_.intrinsics);
    options.focal_prior = fit.lens.fx;
    Reconstruction out = turn(used_, shot_.length(), fit.lens, options);
    monitor_.step("bundle adjustment", 1, 1);
    return out;
  }

  SfmResult turned(const Reconstruction& rotations) {
    result_.motion = ClipMotion::turning;
    result_.focal_estimated = !options_.intrinsics;
    result_.reason = fmt::format("rotation leaves {:.2f} px of the motion unexplained", result_.parallax_px);
    fill_cameras(result_, rotations, placement());
    fill_errors(result_, rotations, used_, options_.max_error_px, scale());
    return std::move(result_);
  }

  /// First those between which most lenses lie: beginnings from both sides that meet leave nothing to search.
  Exploration exploration_of(const std::vector<int>& keyframes, const std::vector<FramePair>& pairs) const {
    Exploration out;
    if (options_.intrinsics)
      out.guesses.push_back({options_.intrinsics->resized(full_, clip_.size), grow_options(!options_.intrinsics)});
    out.first_guesses = out.guesses.size() + 2;
    for (const double fov : {40, 85, 60, 110, 25})
      out.guesses.push_back({lens_of_fov(fov, clip_.size), grow_options(true)});
    out.keyframes = keyframes;
    out.pairs = pairs;
    out.size = clip_.size;
    out.frames = shot_.length();
    return out;
  }

  Outcome explore(const std::vector<int>& keyframes, const std::vector<FramePair>& pairs) {
    const std::vector<Track> few = thinned(tracks_, keyframes, tried_per_frame);
    const Exploration exploration = exploration_of(keyframes, pairs);
    const std::vector<Trial> trials = try_beginnings(few, exploration, pool_, monitor_);
    const std::size_t all = exploration.guesses.size();
    Outcome outcome = carry_on(few, exploration, trials, 0, options_.intrinsics ? 1 : all, monitor_);
    if (options_.intrinsics && lens_is_suspect(trials, exploration.guesses.front().lens)) {
      const Outcome free = carry_on(few, exploration, trials, 1, all, monitor_);
      const double given_error = outcome.found ? std::sqrt(outcome.misfit) : options_.max_error_px;
      if (free.found)
        doubt_lens(doubt_of({exploration.guesses.front().lens, given_error},
                            {free.reconstruction.lens, std::sqrt(free.misfit)}, clip_.size));
    }
    if (outcome.found) adjust_all(outcome.reconstruction);
    return outcome;
  }

  /// Tracks are freed from drift, which would decide the accuracy; beginnings do not need that.
  /// The cameras found on few tracks carry over; the points are new, and so are some frames between.
  void adjust_all(Reconstruction& reconstruction) {
    monitor_.step("bundle adjustment", 0, 2);
    tracks_ = refined_tracks(shot_frames(), clip_.size, tracks_, pool_);
    use_tracks();
    const GrowOptions options = grow_options(!options_.intrinsics);
    reconstruction.points.assign(used_.size(), std::nullopt);
    triangulate_all(reconstruction, used_, options.max_error_px, min_ray_angle);
    const auto wanted = std::min(adjusted_frames, shot_.length());
    for (int i = 0; i < wanted; ++i) {
      const int frame = wanted > 1 ? i * (shot_.length() - 1) / (wanted - 1) : 0;
      if (!reconstruction.cam_from_world[static_cast<std::size_t>(frame)])
        resect(reconstruction, used_, frame, options.max_error_px, options.seed);
    }
    monitor_.step("bundle adjustment", 1, 2);
    settle(reconstruction, used_, options);
    monitor_.step("bundle adjustment", 2, 2);
  }

  Placement placement() const { return {shot_.begin, clip_.frames, full_, clip_.size}; }

  /// The adjusted cameras with a point for every track that has one, not only for those that were adjusted, and from
  /// these a pose for the frames that were not.
  Reconstruction completed(Reconstruction reconstruction) const {
    reconstruction.points.assign(tracks_.size(), std::nullopt);
    triangulate_all(reconstruction, tracks_, options_.max_error_px, min_ray_angle);
    place_others(reconstruction, tracks_, options_.max_error_px, options_.seed, pool_);
    triangulate_all(reconstruction, tracks_, options_.max_error_px, min_ray_angle);
    return reconstruction;
  }

  SfmResult moved(const Outcome& outcome) {
    const double limit = options_.max_error_px;
    if (!outcome.found || outcome.misfit > 0.7 * limit * limit)
      return indeterminate(fmt::format(
          "tracks move, but no camera path{} explains them: {} beginnings tried, best residual {:.2f} of {:.2f} px",
          options_.intrinsics ? " through the given lens" : "", outcome.tried, std::sqrt(outcome.misfit), limit));
    const Reconstruction all = completed(outcome.reconstruction);
    const auto posed = static_cast<int>(all.registered().size());
    if (2 * posed < shot_.length())
      return indeterminate(fmt::format("only {} of {} frames could be placed", posed, shot_.length()));
    result_.motion = ClipMotion::moving;
    result_.focal_estimated = !options_.intrinsics;
    fill_cameras(result_, all, placement());
    fill_errors(result_, all, tracks_, limit, scale());
    fill_points(result_, all, tracks_, limit, placement());
    result_.reason =
        fmt::format("{:.1f} px of parallax; {} of {} frames placed, {} points, error {:.2f} px{}", result_.parallax_px,
                    posed, shot_.length(), result_.points.size(), result_.rms_error_px,
                    outcome.from_plane ? "; nearly one plane is seen, its homography began" : "");
    return std::move(result_);
  }

  std::span<const ImageRgb> frames_;
  const SfmOptions& options_;
  ThreadPool& pool_;
  Monitor& monitor_;
  Size full_;
  TrackedClip clip_;
  Shot shot_;
  std::vector<Track> tracks_;
  std::vector<Track> used_;  // those that take part in the adjustment
  SfmResult result_;
};

}  // namespace

std::string_view to_string(ClipMotion motion) {
  switch (motion) {
    case ClipMotion::moving: return "moving";
    case ClipMotion::turning: return "turning";
    case ClipMotion::still: return "still";
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
