// SPDX-License-Identifier: Apache-2.0
#include "bench/geometry.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <thread>

#include "bench/colmap.h"
#include "bench/timing.h"

namespace uwv::bench {
namespace {

/// Programs that wanted a processor during the last minute, on average: who else was at work.
double machine_load() {
  double load = 0;
  return ::getloadavg(&load, 1) == 1 ? load : std::nan("");
}

bool wanted(const BenchOptions& options, const char* table) {
  return std::find(options.tables.begin(), options.tables.end(), table) != options.tables.end();
}

FoundCameras find_cameras(const TrueClip& clip, bool known_focal, ThreadPool& pool, Monitor& monitor) {
  SfmOptions options;
  if (known_focal) options.intrinsics = clip.cameras.front().intrinsics;
  const Stopwatch watch;
  SfmResult found = structure_from_motion(clip.frames, options, pool, monitor);
  return {std::move(found), watch.processor_seconds()};
}

void add_cameras(Table& table, const std::string& method, const std::string& result, const CameraScore& score,
                 double rms_px, double seconds, double processor_seconds) {
  table.add({method, result, score.cameras, figure(score.ate), figure(score.ate_percent), figure(score.rotation_deg),
             figure(score.focal_percent), figure(rms_px), seconds, processor_seconds});
}

void add_ours(Table& table, const std::string& method, const FoundCameras& found, const TrueClip& truth) {
  const SfmResult& result = found.result;
  add_cameras(table, method, std::string(to_string(result.motion)),
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
  add_cameras(table, known_focal ? "COLMAP, known focal" : "COLMAP, own focal",
              found.failure.empty() ? fmt::format("{} points", found.points) : found.failure,
              score_cameras(found.cameras, found.registered, truth.cameras), std::nan(""), found.seconds,
              found.processor_seconds);
}

}  // namespace

bool StageClock::progress(std::string_view stage, long, long) {
  const auto now = std::chrono::steady_clock::now();
  auto entry = std::find_if(stages_.begin(), stages_.end(), [&](const auto& each) { return each.first == stage; });
  if (entry == stages_.end()) entry = stages_.insert(stages_.end(), {std::string(stage), 0.0});
  entry->second += std::chrono::duration<double>(now - last_).count();
  last_ = now;
  return true;
}

std::vector<ScenePoint> true_points(const TrueClip& clip) {
  constexpr int across = 24, down = 14;
  constexpr double same_surface = 0.01;
  const std::size_t every_frame = clip.frames.size() < 10 ? 1 : 5;
  std::vector<ScenePoint> points;
  const Size size = clip.frames.front().size();
  for (std::size_t f = 0; f < clip.frames.size(); f += every_frame)
    for (int j = 0; j < down; ++j)
      for (int i = 0; i < across; ++i) {
        const int x = (2 * i + 1) * size.width / (2 * across), y = (2 * j + 1) * size.height / (2 * down);
        const bool at_rest = clip.static_pixels.empty() || clip.static_pixels[f](x, y) != 0;
        const double depth = static_cast<double>(clip.depths[f](x, y));
        if (!at_rest || depth <= 0) continue;
        ScenePoint point;
        point.x_in_world =
            clip.cameras[f].world_from_cam * unproject(clip.cameras[f].intrinsics, {x + 0.5, y + 0.5}, depth);
        for (std::size_t g = 0; g < clip.frames.size(); ++g) {
          const Eigen::Vector3d x_in_cam = clip.cameras[g].cam_from_world() * point.x_in_world;
          Eigen::Vector2d pixel;
          if (!project(clip.cameras[g].intrinsics, x_in_cam, pixel)) continue;
          if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < size.width && pixel.y() < size.height)) continue;
          const auto seen =
              static_cast<double>(clip.depths[g](static_cast<int>(pixel.x()), static_cast<int>(pixel.y())));
          if (std::abs(seen - x_in_cam.z()) < same_surface * x_in_cam.z())
            point.observations.push_back({static_cast<int>(g), pixel});
        }
        points.push_back(std::move(point));
      }
  return points;
}

Table camera_table(const FoundClip& clip, const BenchOptions& options) {
  Table table("cameras of " + clip.truth.name, {"method", "result", "cameras", "ate", "ate_%", "rotation_deg",
                                                "focal_%", "rms_px", "seconds", "cpu_seconds"});
  add_ours(table, "known focal", clip.known_focal, clip.truth);
  add_ours(table, "own focal", clip.own_focal, clip.truth);
  if (!options.colmap_folder.empty())
    for (const bool known : {true, false}) add_colmap(table, clip.truth, known, options);
  else
    fmt::print("COLMAP left out: no folder for it to work in was given with --colmap\n");
  return table;
}

Table stage_table(const TrueClip& clip, ThreadPool& pool) {
  Table table(fmt::format("stages of {}, {} frames of {}x{}", clip.name, clip.frames.size(),
                          clip.frames.front().width(), clip.frames.front().height()),
              {"part", "stage", "seconds"});
  const auto add = [&](const char* part, const StageClock& clock, double seconds) {
    for (const auto& [stage, took] : clock.stages()) table.add({part, stage, took});
    table.add({part, "all", seconds});
  };
  StageClock motion_clock;
  const SfmResult found = find_cameras(clip, false, pool, motion_clock).result;
  add("structure from motion", motion_clock, found.seconds);
  if (found.motion != ClipMotion::moving) return table;
  StageClock stereo_clock;
  std::vector<FrameGeometry> depths;
  const MvsSummary summary =
      multi_view_stereo(clip.frames, found.cameras, found.points, clip.static_pixels, {}, pool, stereo_clock, depths);
  add("multi-view stereo", stereo_clock, summary.seconds);
  return table;
}

namespace {

constexpr std::string_view known_tables[] = {"cameras", "camera_options", "choices", "depth", "stages", "views"};

}  // namespace

std::vector<Table> geometry(const BenchOptions& options) {
  options.check();
  for (const std::string& table : options.tables)
    if (std::find(std::begin(known_tables), std::end(known_tables), table) == std::end(known_tables))
      fail(ErrorCode::value_invalid, "--tables: found '{}', wanted some of {}", table, fmt::join(known_tables, ", "));
  ResizePolicy resize;
  if (options.no_resize) resize.mode = ResizePolicy::Mode::none;
  ThreadPool pool(options.threads);
  Monitor monitor;
  const TrueClip truth = read_true_clip(options.recording, {options.start, options.stride, options.frames}, resize);
  Table machine("machine", {"processors", "threads", "load_before", "load_after"});
  const double load_before = machine_load();
  std::vector<Table> tables;
  if (wanted(options, "camera_options")) tables.push_back(camera_option_table(truth, pool));
  if (wanted(options, "stages")) tables.push_back(stage_table(truth, pool));
  if (wanted(options, "choices"))
    for (Table& table : choice_tables(truth, options, pool)) tables.push_back(std::move(table));
  if (wanted(options, "cameras") || wanted(options, "depth") || wanted(options, "views")) {
    const FoundClip found{truth, pool, find_cameras(truth, true, pool, monitor),
                          find_cameras(truth, false, pool, monitor)};
    if (wanted(options, "cameras")) tables.push_back(camera_table(found, options));
    if (wanted(options, "depth")) tables.push_back(depth_table(found, options));
    if (wanted(options, "views")) tables.push_back(view_table(found, options));
  }
  machine.add({std::thread::hardware_concurrency(), pool.size(), figure(load_before), figure(machine_load())});
  tables.push_back(machine);
  return tables;
}

}  // namespace uwv::bench
