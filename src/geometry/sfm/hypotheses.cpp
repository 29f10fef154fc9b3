// SPDX-License-Identifier: Apache-2.0
#include "geometry/sfm/hypotheses.h"

#include <algorithm>
#include <numeric>

namespace uwv::sfm {

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

Outcome reconstruct(const std::vector<Track>& tracks, int frames, std::span<const int> keyframes,
                    std::span<const FramePair> pairs, const Exploration& exploration, Monitor& monitor) {
  const std::vector<Track> few = thinned(tracks, keyframes, 200);
  const double limit = exploration.grow.max_error_px;
  const bool known = exploration.lenses.size() == 1;
  const std::size_t pairs_tried = known ? 4 : 2;
  Outcome best;
  Intrinsics best_lens;
  best.misfit = limit * limit;
  for (const Intrinsics& lens : exploration.lenses) {
    const std::vector<FramePair> ranked = rank_pairs(few, pairs, lens, exploration.size);
    for (std::size_t p = 0; p < std::min(pairs_tried, ranked.size()); ++p) {
      for (const TwoViewStart& start : starts_of(few, ranked[p], lens, limit)) {
        monitor.step("cameras", best.tried++, 0);
        const Reconstruction trial = grow(few, frames, keyframes, lens, start, exploration.grow);
        const double error = misfit(trial, few, keyframes, limit);
        if (error >= best.misfit) continue;
        best.misfit = error;
        best.found = true;
        best.from_plane = start.from_plane;
        best_lens = trial.lens;
        best.reconstruction.cam_from_world = trial.cam_from_world;
      }
      if (known && best.misfit < 0.15 * limit * limit) break;  // nothing better is to be expected
    }
  }
  if (!best.found) return best;
  // The cameras found on few tracks carry over; only the points are new.
  Reconstruction& out = best.reconstruction;
  out.lens = best_lens;
  out.points.assign(tracks.size(), std::nullopt);
  monitor.step("bundle adjustment", 0, 1);
  finish(out, tracks, exploration.grow);
  monitor.step("bundle adjustment", 1, 1);
  return best;
}

}  // namespace uwv::sfm
