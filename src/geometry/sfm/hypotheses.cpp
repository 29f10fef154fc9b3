// SPDX-License-Identifier: Apache-2.0
#include "geometry/sfm/hypotheses.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace uwv::sfm {
namespace {

constexpr std::size_t pairs_tried = 3;
constexpr std::size_t frames_tried = 8;  // key frames a beginning is judged by
constexpr std::size_t most_carried = 3;  // beginnings that may grow over all key frames
constexpr double convincing = 0.15;      // of the squared error limit: nothing better is to be expected

/// Some key frames in and around the pair, both of it among them, ascending.
std::vector<int> frames_around(std::span<const int> keyframes, const FramePair& pair) {
  const auto place = [&](int frame) {
    return static_cast<double>(std::lower_bound(keyframes.begin(), keyframes.end(), frame) - keyframes.begin());
  };
  const double a = place(pair.a), b = place(pair.b), last = static_cast<double>(keyframes.size()) - 1;
  const double width = std::min(last, std::max(1.5 * (b - a), frames_tried - 1.0));
  const double from = std::clamp((a + b - width) / 2, 0.0, last - width);
  std::vector<int> out{pair.a, pair.b};
  for (std::size_t i = 0; i < frames_tried; ++i) {
    const double at = from + width * static_cast<double>(i) / (frames_tried - 1);
    out.push_back(keyframes[static_cast<std::size_t>(std::lround(at))]);
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

/// 1 for the expected focal length, 1.05 for one that is 0.5 off in its logarithm.
double unlikelihood(const Intrinsics& lens, const GrowOptions& options) {
  if (!options.refine_focal) return 1;
  const double off = std::log(lens.fx / options.focal_prior) / 0.5;
  return 1 + 0.05 * off * off;
}

/// Whether beginnings with different lenses ended with the same one, as well as any. `trials`: best first.
bool lens_is_settled(const std::vector<Trial>& trials, const Exploration& exploration) {
  const Trial* best = nullptr;
  for (const Trial& trial : trials) {
    if (!exploration.guesses[trial.guess].grow.refine_focal) continue;
    if (best == nullptr) best = &trial;
    if (trial.score > 1.1 * best->score) return false;
    const double ratio = trial.reconstruction.lens.fx / best->reconstruction.lens.fx;
    if (trial.guess != best->guess && std::abs(std::log(ratio)) < 0.03) return true;
  }
  return false;
}

std::vector<Trial> try_pair(const std::vector<Track>& few, const Exploration& exploration, std::size_t guess,
                            const FramePair& pair) {
  const auto& [lens, options] = exploration.guesses[guess];
  const std::vector<int> around = frames_around(exploration.keyframes, pair);
  std::vector<Trial> out;
  for (const TwoViewStart& start : starts_of(few, pair, lens, options.max_error_px, options.seed)) {
    Trial trial{guess, start.from_plane, begin(few, exploration.frames, lens, start, options)};
    grow(trial.reconstruction, few, around, options);
    trial.misfit = misfit(trial.reconstruction, few, around, options.max_error_px);
    trial.score = trial.misfit * unlikelihood(trial.reconstruction.lens, options);
    out.push_back(std::move(trial));
  }
  return out;
}

}  // namespace

std::vector<Track> thinned(const std::vector<Track>& tracks, std::span<const int> frames, int per_frame) {
  const auto views = [&](const Track& track) {
    return std::count_if(frames.begin(), frames.end(), [&](int f) { return track.in(f); });
  };
  std::vector<std::size_t> order(tracks.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::vector<long> seen(tracks.size());
  for (std::size_t t = 0; t < tracks.size(); ++t) seen[t] = views(tracks[t]);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return seen[a] > seen[b]; });
  std::vector<int> held(frames.size(), 0);
  std::vector<Track> out;
  for (const std::size_t t : order) {
    if (seen[t] < 2) break;
    bool wanted = false;
    for (std::size_t i = 0; i < frames.size(); ++i) wanted = wanted || (tracks[t].in(frames[i]) && held[i] < per_frame);
    if (!wanted) continue;
    for (std::size_t i = 0; i < frames.size(); ++i) held[i] += tracks[t].in(frames[i]) ? 1 : 0;
    out.push_back(tracks[t]);
  }
  return out;
}

std::vector<Trial> try_beginnings(const std::vector<Track>& few, const Exploration& exploration, ThreadPool& pool,
                                  Monitor& monitor) {
  // One ranking for all lenses: their trials can then be compared pair by pair.
  std::vector<FramePair> ranked =
      rank_pairs(few, exploration.pairs, exploration.guesses.front().lens, exploration.size);
  ranked.resize(std::min(pairs_tried, ranked.size()));
  const std::size_t jobs = exploration.guesses.size() * ranked.size();
  const auto batch = static_cast<std::size_t>(pool.size());
  std::vector<Trial> out;
  const auto try_jobs = [&](std::size_t from, std::size_t to) {
    std::vector<std::vector<Trial>> tried(to - from);
    for (std::size_t done = from; done < to; done += batch) {
      monitor.step("cameras", static_cast<long>(done), static_cast<long>(jobs));
      pool.run(static_cast<int>(std::min(batch, to - done)), [&](int part) {
        const std::size_t job = done + static_cast<std::size_t>(part);
        tried[job - from] = try_pair(few, exploration, job / ranked.size(), ranked[job % ranked.size()]);
      });
    }
    for (std::vector<Trial>& of_job : tried)
      for (Trial& trial : of_job) out.push_back(std::move(trial));
    std::stable_sort(out.begin(), out.end(), [](const Trial& a, const Trial& b) { return a.score < b.score; });
  };
  const std::size_t first = std::min(jobs, exploration.first_guesses * ranked.size());
  try_jobs(0, first);
  if (!lens_is_settled(out, exploration)) try_jobs(first, jobs);
  return out;
}

Outcome carry_on(const std::vector<Track>& few, const Exploration& exploration, const std::vector<Trial>& trials,
                 std::size_t from, std::size_t to, Monitor& monitor) {
  Outcome best;
  best.tried = static_cast<int>(trials.size());
  std::size_t carried = 0;
  double least = 0;
  for (const Trial& trial : trials) {
    if (trial.guess < from || trial.guess >= to) continue;
    if (carried == most_carried) break;
    monitor.step("cameras", static_cast<long>(carried++), static_cast<long>(most_carried));
    const GrowOptions& options = exploration.guesses[trial.guess].grow;
    const double limit = options.max_error_px * options.max_error_px;
    Reconstruction grown = trial.reconstruction;
    grow(grown, few, exploration.keyframes, options);
    const double error = misfit(grown, few, exploration.keyframes, options.max_error_px);
    const double score = error * unlikelihood(grown.lens, options);
    if (error >= limit || (best.found && score >= least)) continue;
    least = score;
    best.misfit = error;
    best.found = true;
    best.from_plane = trial.from_plane;
    best.reconstruction = std::move(grown);
    if (error < convincing * limit) break;
  }
  best.reconstruction.points.clear();
  return best;
}

}  // namespace uwv::sfm
