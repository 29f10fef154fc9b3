// SPDX-License-Identifier: Apache-2.0
#include "bench/geometry.h"
#include "bench/stereo_pairs.h"

namespace uwv::bench {
namespace {

/// Two views far apart have more disparities than neighbours in a clip.
std::vector<MvsVariant> variants() {
  std::vector<MvsVariant> all{{"default", {}}};
  for (const auto& [planes, scale] : {std::pair(128, 0.75), {64, 1.0}, {128, 1.0}, {256, 1.0}}) {
    MvsOptions options;
    options.planes = planes;
    options.scale = scale;
    all.push_back({fmt::format("planes={} scale={}", planes, scale), options});
  }
  return all;
}

}  // namespace

std::vector<Table> stereo_depth(const BenchOptions& options) {
  options.check();
  ResizePolicy resize;
  resize.mode = ResizePolicy::Mode::none;
  ThreadPool pool(options.threads);
  std::vector<std::string> columns{"pair", "size", "option"};
  columns.insert(columns.end(), depth_columns().begin(), depth_columns().end());
  Table table("depth of stereo pairs", columns);
  for (const std::string& folder : options.stereo) {
    if (!is_stereo_pair(folder)) {
      fmt::print("{} left out: it holds none of im2.png, view1.png and motorcycle_left.png\n", folder);
      continue;
    }
    const TrueClip clip = read_stereo_pair(folder, resize);
    const std::vector<ScenePoint> points = true_points(clip);
    const Size size = clip.frames.front().size();
    for (const MvsVariant& variant : variants()) {
      std::vector<nlohmann::ordered_json> row{clip.name, fmt::format("{}x{}", size.width, size.height), variant.name};
      const MvsMeasured measured =
          measure_stereo(clip, {clip.cameras, points, {}}, variant.options, 1, options.mvs_runs, pool);
      for (auto& value : depth_figures(measured, clip.frames.size())) row.push_back(std::move(value));
      table.add(row);
    }
  }
  if (table.json().empty()) fail(ErrorCode::file_not_found, "no stereo pair to judge: give folders with --stereo");
  return {table};
}

}  // namespace uwv::bench
