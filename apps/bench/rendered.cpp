// SPDX-License-Identifier: Apache-2.0
// Cameras and depth of clips whose truth is exact, from easy to hopeless: who manages which.
#include <algorithm>

#include "bench/dungeon_clip.h"
#include "bench/geometry.h"

namespace uwv::bench {
namespace {

struct Case {
  std::string name;
  DungeonOptions clip;
};

std::vector<Case> all_cases(int frames) {
  std::vector<Case> cases;
  const auto add = [&](std::string name, auto change) {
    DungeonOptions clip;
    clip.frames = frames;
    clip.figure = false;
    change(clip);
    cases.push_back({std::move(name), clip});
  };
  const auto with_figure = [](double distance) {
    return [distance](DungeonOptions& o) { o.figure = true, o.figure_distance = distance; };
  };
  add("hall", [](DungeonOptions&) {});
  add("figure", with_figure(4));
  add("near_figure", with_figure(2));
  add("huge_figure", with_figure(1.4));
  add("four_frames", [](DungeonOptions& o) { o.frames = 4; });
  add("little_texture", [](DungeonOptions& o) { o.texture = 0.1; });
  add("no_texture", [](DungeonOptions& o) { o.texture = 0; });
  add("short_way", [](DungeonOptions& o) { o.travel = 0.1; });
  add("tiny_way", [](DungeonOptions& o) { o.travel = 0.02; });
  add("turning", [](DungeonOptions& o) { o.travel = 0; });
  return cases;
}

std::vector<Case> chosen_cases(const BenchOptions& options) {
  const std::vector<Case> all = all_cases(options.frames);
  if (options.cases.empty()) return all;
  std::vector<Case> chosen;
  for (const std::string& name : options.cases) {
    const auto found = std::find_if(all.begin(), all.end(), [&](const Case& each) { return each.name == name; });
    if (found == all.end()) {
      std::string known;
      for (const Case& each : all) known += (known.empty() ? "" : ", ") + each.name;
      fail(ErrorCode::value_invalid, "--cases: found '{}', wanted some of {}", name, known);
    }
    chosen.push_back(*found);
  }
  return chosen;
}

void add_depth(Table& table, const FoundClip& found, const char* cameras, const MvsMeasured& measured) {
  std::vector<nlohmann::ordered_json> row{found.truth.name, cameras};
  for (auto& value : depth_figures(measured, found.truth.frames.size())) row.push_back(std::move(value));
  table.add(row);
}

}  // namespace

std::vector<Table> rendered_clips(const BenchOptions& options) {
  options.check();
  ThreadPool pool(options.threads);
  const Machine machine(pool);
  Table cameras = camera_table("cameras of rendered clips");
  std::vector<std::string> columns{"clip", "cameras"};
  columns.insert(columns.end(), depth_columns().begin(), depth_columns().end());
  Table depth("depth of rendered clips", columns);
  for (const Case& each : chosen_cases(options)) {
    fmt::print(stderr, "{}: {} frames\n", each.name, each.clip.frames);  // COLMAP makes one wait
    const TrueClip truth = render_clip(dungeon_clip(options.models, options.size, each.clip), each.name, pool);
    const FoundClip found = find_cameras(truth, pool);
    add_cameras(cameras, found, options);
    const std::vector<ScenePoint> points = true_points(truth);
    add_depth(depth, found, "true",
              measure_stereo(truth, {truth.cameras, points, truth.static_pixels}, {}, 0, options.mvs_runs, pool));
    if (found.own_focal.result.motion == ClipMotion::moving)
      add_depth(depth, found, "own focal", measure_found(found, found.own_focal.result, options.mvs_runs));
    else
      fmt::print("{}: depth with found cameras left out: {}\n", each.name, found.own_focal.result.reason);
  }
  return {cameras, depth, machine.table()};
}

}  // namespace uwv::bench
