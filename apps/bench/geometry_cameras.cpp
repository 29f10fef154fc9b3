// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "bench/colmap.h"
#include "bench/geometry.h"
#include "bench/timing.h"

namespace uwv::bench {
namespace {

FoundCameras find_cameras(const TrueClip& clip, bool known_focal, ThreadPool& pool) {
  SfmOptions options;
  if (known_focal) options.intrinsics = clip.cameras.front().intrinsics;
  Monitor monitor;
  const Stopwatch watch;
  SfmResult found = structure_from_motion(clip.frames, options, pool, monitor);
  return {std::move(found), watch.processor_seconds()};
}

void add_row(Table& table, const std::string& clip, const std::string& method, const std::string& result,
             const CameraScore& score, double rms_px, double seconds, double processor_seconds) {
  table.add({clip, method, result, score.cameras, figure(score.ate), figure(score.ate_percent),
             figure(score.rotation_deg), figure(score.focal_percent), figure(rms_px), seconds, processor_seconds});
}

void add_ours(Table& table, const std::string& method, const FoundCameras& found, const TrueClip& truth) {
  const SfmResult& result = found.result;
  add_row(table, truth.name, method, std::string(to_string(result.motion)),
          score_cameras(result.cameras, result.registered, truth.cameras), result.rms_error_px, result.seconds,
          found.processor_seconds);
  if (result.motion != ClipMotion::moving) fmt::print("{}, {}: {}\n", truth.name, method, result.reason);
}

void add_colmap(Table& table, const TrueClip& truth, bool known_focal, const BenchOptions& options) {
  ColmapOptions colmap;
  if (known_focal) colmap.intrinsics = truth.cameras.front().intrinsics;
  colmap.threads = options.threads;
  colmap.patience_seconds = options.colmap_patience;
  const ColmapResult found = run_colmap(truth.frames, options.colmap_folder, colmap);
  add_row(table, truth.name, known_focal ? "COLMAP, known focal" : "COLMAP, own focal",
          found.failure.empty() ? fmt::format("{} points", found.points) : found.failure,
          score_cameras(found.cameras, found.registered, truth.cameras), std::nan(""), found.seconds,
          found.processor_seconds);
}

}  // namespace

FoundClip find_cameras(const TrueClip& clip, ThreadPool& pool) {
  return {clip, pool, find_cameras(clip, true, pool), find_cameras(clip, false, pool)};
}

Table camera_table(const std::string& name) {
  return {name,
          {"clip", "method", "result", "cameras", "ate", "ate_%", "rotation_deg", "focal_%", "rms_px", "seconds",
           "cpu_seconds"}};
}

void add_cameras(Table& table, const FoundClip& clip, const BenchOptions& options) {
  add_ours(table, "ours, known focal", clip.known_focal, clip.truth);
  add_ours(table, "ours, own focal", clip.own_focal, clip.truth);
  if (options.colmap_folder.empty()) {
    fmt::print("{}: COLMAP left out: no folder for it to work in was given with --colmap\n", clip.truth.name);
    return;
  }
  for (const bool known : {true, false}) add_colmap(table, clip.truth, known, options);
}

}  // namespace uwv::bench
