// SPDX-License-Identifier: Apache-2.0
#include "bench/geometry.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <thread>

#include "bench/timing.h"

namespace uwv::bench {
namespace {

bool wanted(const BenchOptions& options, const char* table) {
  return std::find(options.tables.begin(), options.tables.end(), table) != options.tables.end();
}

}  // namespace

Machine::Machine(const ThreadPool& pool) : threads_(pool.size()), load_before_(load()) {}

double Machine::load() {
  double load = 0;
  return ::getloadavg(&load, 1) == 1 ? load : std::nan("");
}

Table Machine::table() const {
  Table table("machine", {"processors", "threads", "load_before", "load_after"});
  table.add({std::thread::hardware_concurrency(), threads_, figure(load_before_), figure(load())});
  return table;
}

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

Table stage_table(const TrueClip& clip, ThreadPool& pool) {
  Table table(fmt::format("stages of {}, {} frames of {}x{}", clip.name, clip.frames.size(),
                          clip.frames.front().width(), clip.frames.front().height()),
              {"part", "stage", "seconds"});
  const auto add = [&](const char* part, const StageClock& clock, double seconds) {
    for (const auto& [stage, took] : clock.stages()) table.add({part, stage, took});
    table.add({part, "all", seconds});
  };
  StageClock motion_clock;
  const SfmResult found = structure_from_motion(clip.frames, {}, pool, motion_clock);
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
  const TrueClip truth = read_true_clip(options.recording, {options.start, options.stride, options.frames}, resize);
  const Machine machine(pool);
  std::vector<Table> tables;
  if (wanted(options, "camera_options")) tables.push_back(camera_option_table(truth, pool));
  if (wanted(options, "stages")) tables.push_back(stage_table(truth, pool));
  if (wanted(options, "choices"))
    for (Table& table : choice_tables(truth, options, pool)) tables.push_back(std::move(table));
  if (wanted(options, "cameras") || wanted(options, "depth") || wanted(options, "views")) {
    const FoundClip found = find_cameras(truth, pool);
    if (wanted(options, "cameras")) {
      Table cameras = camera_table("cameras of " + truth.name);
      add_cameras(cameras, found, options);
      tables.push_back(std::move(cameras));
    }
    if (wanted(options, "depth")) tables.push_back(depth_table(found, options));
    if (wanted(options, "views")) tables.push_back(view_table(found, options));
  }
  tables.push_back(machine.table());
  return tables;
}

}  // namespace uwv::bench
