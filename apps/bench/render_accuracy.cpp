// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <numbers>

#include "bench/benchmarks.h"
#include "uwv/eval/image_metrics.h"
#include "uwv/eval/path_truth.h"
#include "uwv/eval/wrong_surface.h"
#include "uwv/render/occlusion.h"

namespace uwv::bench {
namespace {

struct Variant {
  std::string name;
  OcclusionOptions options;
};

/// The default and what changes when one option changes.
std::vector<Variant> variants() {
  OcclusionOptions base;
  base.reliability.enabled = false;  // the truth is about every pixel, and synthetic depth is exact
  std::vector<Variant> all{{"default", base}};
  const auto add = [&](std::string name, auto change) {
    OcclusionOptions options = base;
    change(options);
    all.push_back({std::move(name), options});
  };
  add("kernel=nearest", [](auto& o) { o.kernel = Kernel::nearest; });
  add("kernel=bilinear (official)", [](auto& o) { o.kernel = Kernel::bilinear; });
  add("visibility=ztest", [](auto& o) { o.visibility = Visibility::ztest; });
  add("depth_tolerance=0.05", [](auto& o) { o.depth_tolerance = 0.05F; });
  add("point_size=0.7", [](auto& o) { o.footprint.point_size = 0.7F; });
  add("point_size=1.15", [](auto& o) { o.footprint.point_size = 1.15F; });
  add("max_footprint=1", [](auto& o) { o.footprint.max_footprint = 1; });
  add("max_footprint=4", [](auto& o) { o.footprint.max_footprint = 4; });
  add("max_footprint=64", [](auto& o) { o.footprint.max_footprint = 64; });
  add("slope radius=3", [](auto& o) { o.slopes.radius = 3; });
  add("alpha=60", [](auto& o) { o.alpha = std::numbers::pi / 3; });
  add("normal_filter=off", [](auto& o) { o.normal_filter = false; });
  add("reliability=on", [](auto& o) { o.reliability.enabled = true; });
  add("naive", [](auto& o) {
    o.visibility = Visibility::none;
    o.normal_filter = false;
  });
  add("naive bilinear", [](auto& o) {
    o.visibility = Visibility::none;
    o.normal_filter = false;
    o.kernel = Kernel::bilinear;
  });
  return all;
}

StockScene scene_named(const BenchOptions& options) {
  std::string known;
  for (StockScene& scene : stock_scenes({.size = options.size})) {
    if (scene.name == options.scene) return std::move(scene);
    known += (known.empty() ? "" : ", ") + scene.name;
  }
  fail(ErrorCode::value_invalid, "scene '{}' is unknown; choose one of: {}", options.scene, known);
}

}  // namespace

std::vector<Table> render_accuracy(const BenchOptions& options) {
  options.check();
  ThreadPool pool(options.threads);
  const StockScene scene = scene_named(options);
  const SyntheticFrame source_frame = render(scene.scene, scene.source, 0, pool, 2);
  const auto rasterizer = make_cpu_rasterizer(pool);
  Table table(fmt::format("{}, {} frames to each angle", scene.name, options.steps),
              {"degrees", "options", "ms_per_frame", "M''_precision", "M''_recall", "Mvis_precision", "Mvis_recall",
               "valid", "wrong_%", "unknowable_%", "holes_%", "psnr"});
  for (const double degrees : {5.0, 20.0, 45.0, 70.0, 90.0}) {
    const PathTruth path = path_truth(scene.scene, scene.source,
                                      orbit_path(scene, degrees * std::numbers::pi / 180, options.steps), 0, pool);
    const MetricImage seen(render(scene.scene, path.cameras.back(), 0, pool, 2).colour);
    for (const Variant& variant : variants()) {
      OcclusionRenderer renderer(*rasterizer, pool, variant.options);
      RenderedFrame out;
      FrameMasks masks;
      SourceFrame source;
      source.camera = scene.source;
      source.colour = &source_frame.colour;
      source.depth = &source_frame.depth;
      double seconds = 0;
      for (const Camera& camera : path.cameras) {
        ++source.index;  // as in a video: everything is computed for every frame
        seconds += renderer.render(source, camera, out, &masks).seconds;
      }
      const PrecisionRecall second = compare(masks.second, path.last), visible = compare(masks.visible, path.product);
      const std::array<Camera, 1> sources{scene.source};
      const WrongSurface wrong =
          wrong_surface(scene.scene, 0, path.cameras.back(), sources, out.depth, out.valid, pool);
      table.add({degrees, variant.name, seconds * 1e3 / options.steps, second.precision(), second.recall(),
                 visible.precision(), visible.recall(), valid_share(out.valid), 100 * wrong.wrong_share(),
                 wrong.valid > 0 ? 100.0 * static_cast<double>(wrong.through_unknown) / static_cast<double>(wrong.valid)
                                 : 0.0,
                 100 * wrong.hole_share(), psnr(MetricImage(out.colour), seen, &out.valid)});
    }
  }
  return {table};
}

}  // namespace uwv::bench
