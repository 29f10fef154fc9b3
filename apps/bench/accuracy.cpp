// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy.h"

#include <fmt/format.h>

#include <numbers>
#include <utility>

#include "bench/timing.h"

namespace uwv::bench {

StockScene scene_named(const std::string& name, Size size) {
  std::string known;
  for (StockScene& scene : stock_scenes({.size = size})) {
    if (scene.name == name) return std::move(scene);
    known += (known.empty() ? "" : ", ") + scene.name;
  }
  fail(ErrorCode::value_invalid, "scene '{}' is unknown; choose one of: {}", name, known);
}

Lab::Lab(StockScene stock, ThreadPool& threads)
    : pool(threads), rasterizer(make_cpu_rasterizer(threads)), scene(std::move(stock)), seen(view(scene.source)) {}

SourceFrame Lab::source() const {
  SourceFrame source;
  source.camera = scene.source;
  source.colour = &seen.colour;
  source.depth = &seen.depth;
  return source;
}

PathTruth Lab::orbit(double degrees, int steps) const {
  return path_truth(scene.scene, scene.source, orbit_path(scene, degrees * std::numbers::pi / 180, steps), 0, pool);
}

OcclusionOptions unfiltered() {
  OcclusionOptions options;
  options.reliability.enabled = false;
  return options;
}

Followed follow(const Lab& lab, const OcclusionOptions& options, SourceFrame source,
                const std::vector<Camera>& cameras) {
  OcclusionRenderer renderer(*lab.rasterizer, lab.pool, options);
  Followed end;
  std::vector<double> ms;
  for (const Camera& camera : cameras) {
    ++source.index;
    ms.push_back(renderer.render(source, camera, end.frame, &end.masks).seconds * 1e3);
  }
  end.ms = median(std::move(ms));
  return end;
}

std::vector<Table> render_accuracy(const BenchOptions& options) {
  options.check();
  ThreadPool pool(options.threads);
  const Lab lab(scene_named(options.scene, options.size), pool);
  return {option_table(lab, options), resolution_table(options, pool),    depth_width_table(lab, options),
          smeared_depth_table(lab),   skipped_passes_table(lab, options), long_paths_table(lab)};
}

}  // namespace uwv::bench
