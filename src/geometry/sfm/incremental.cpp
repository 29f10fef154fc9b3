// SPDX-License-Identifier: Apache-2.0
#include "geometry/sfm/incremental.h"

#include <algorithm>
#include <set>

#include "geometry/sfm/resection.h"
#include "geometry/sfm/triangulation.h"

namespace uwv::sfm {
namespace {

constexpr double settled_loss_px = 0.3;  // some times the noise of refined tracks; on the way errors are larger

/// The frame that sees most of the known points.
int best_seen(const Reconstruction& reconstruction, const std::vector<Track>& tracks, const std::set<int>& open) {
  int best = -1;
  long most = -1;
  for (const int f : open) {
    long count = 0;
    for (std::size_t t = 0; t < tracks.size(); ++t) count += tracks[t].in(f) && reconstruction.points[t] ? 1 : 0;
    if (count > most) {
      most = count;
      best = f;
    }
  }
  return best;
}

AdjustOptions adjustment(const GrowOptions& options, bool focal) {
  AdjustOptions out;
  out.refine_focal = focal && options.refine_focal;
  out.focal_prior = options.focal_prior;
  out.gate_px = 5 * options.max_error_px;
  out.tolerance = 1e-3;  // on the way; what comes next moves everything again
  return out;
}

/// An assumed focal length is wrong at first, so that early observations miss by more.
double early_error(const GrowOptions& options) { return options.max_error_px * (options.refine_focal ? 3 : 2); }

}  // namespace

Reconstruction begin(const std::vector<Track>& tracks, int frames, const Intrinsics& lens, const TwoViewStart& start,
                     const GrowOptions& options) {
  Reconstruction out;
  out.lens = lens;
  out.cam_from_world.resize(static_cast<std::size_t>(frames));
  out.points.resize(tracks.size());
  out.cam_from_world[static_cast<std::size_t>(start.frames.a)] = Rigid3{};
  out.cam_from_world[static_cast<std::size_t>(start.frames.b)] = start.b_from_a;
  triangulate_all(out, tracks, early_error(options), min_ray_angle);
  adjust(out, tracks, adjustment(options, false));
  triangulate_all(out, tracks, early_error(options), min_ray_angle);
  return out;
}

void grow(Reconstruction& out, const std::vector<Track>& tracks, std::span<const int> keyframes,
          const GrowOptions& options) {
  const double early = early_error(options);
  std::size_t registered = out.registered().size(), adjusted = registered;
  std::set<int> open(keyframes.begin(), keyframes.end());
  for (const int f : out.registered()) open.erase(f);
  while (!open.empty()) {
    const int frame = best_seen(out, tracks, open);
    open.erase(frame);
    if (!resect(out, tracks, frame, early, options.seed)) continue;
    ++registered;
    triangulate_all(out, tracks, early, min_ray_angle);
    if (registered < 5 || 4 * registered > 5 * adjusted) {
      adjust(out, tracks, adjustment(options, registered >= 3));
      triangulate_all(out, tracks, early, min_ray_angle);
      adjusted = registered;
    }
  }
  for (int round = 0; round < 2; ++round) {
    adjust(out, tracks, adjustment(options, true));
    triangulate_all(out, tracks, options.max_error_px, min_ray_angle);
    for (const int f : keyframes)
      if (!out.cam_from_world[static_cast<std::size_t>(f)]) resect(out, tracks, f, options.max_error_px, options.seed);
  }
}

void settle(Reconstruction& reconstruction, const std::vector<Track>& tracks, const GrowOptions& options) {
  for (int round = 0; round < 2; ++round) {
    triangulate_all(reconstruction, tracks, options.max_error_px, min_ray_angle);
    AdjustOptions last = adjustment(options, true);
    last.tolerance = 1e-5;
    last.loss_px = settled_loss_px;
    last.gate_px = (round == 0 ? 2 : 1) * options.max_error_px;
    adjust(reconstruction, tracks, last);
  }
}

void place_others(Reconstruction& reconstruction, const std::vector<Track>& tracks, double max_error_px,
                  std::uint64_t seed, ThreadPool& pool) {
  const auto frames = static_cast<int>(reconstruction.cam_from_world.size());
  std::vector<int> open;
  for (int f = 0; f < frames; ++f)
    if (!reconstruction.cam_from_world[static_cast<std::size_t>(f)]) open.push_back(f);
  std::vector<std::optional<Rigid3>> poses(open.size());
  const Reconstruction& known = reconstruction;
  pool.for_ranges(0, static_cast<int>(open.size()), 1, [&](int from, int to) {
    for (int i = from; i < to; ++i)
      poses[static_cast<std::size_t>(i)] =
          find_pose(known, tracks, open[static_cast<std::size_t>(i)], max_error_px, seed);
  });
  for (std::size_t i = 0; i < open.size(); ++i)
    reconstruction.cam_from_world[static_cast<std::size_t>(open[i])] = poses[i];
}

double misfit(const Reconstruction& reconstruction, const std::vector<Track>& tracks, std::span<const int> keyframes,
              double max_error_px) {
  double sum = 0;
  long count = 0;
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    int views = 0;
    for (const int f : keyframes) views += tracks[t].in(f) ? 1 : 0;
    if (views < 2) continue;
    for (const int f : keyframes) {
      if (!tracks[t].in(f)) continue;
      const double error = std::min(max_error_px, reconstruction.error(tracks[t], t, f));
      sum += error * error;
      ++count;
    }
  }
  return count > 0 ? sum / static_cast<double>(count) : max_error_px * max_error_px;
}

}  // namespace uwv::sfm
