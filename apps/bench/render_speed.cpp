// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>
#include <numbers>

#include "bench/benchmarks.h"
#include "bench/timing.h"
#include "uwv/eval/stock_scenes.h"
#include "uwv/render/gl_rasterizer.h"
#include "uwv/render/occlusion.h"

namespace uwv::bench {
namespace {

/// The scene everything is timed on, seen from 20 degrees to the side.
struct Workload {
  StockScene scene;
  SyntheticFrame frame;
  SlopeMap slopes;
  ValidityMask reliable;
  ImageRgbF colour;
  Camera target;

  Workload(Size size, ThreadPool& pool)
      : scene(sphere_floor_wall({.size = size})),
        frame(render(scene.scene, scene.source, 0, pool)),
        slopes(slopes_from_depth(frame.depth, {}, pool)),
        reliable(reliable_depth(frame.depth, {}, pool)),
        colour(size),
        target(orbit_camera(scene.source, scene.subject_in_world, 20 * std::numbers::pi / 180)) {}

  PointGrid grid() const { return {scene.source, &frame.depth, &slopes, &reliable}; }
  SourceFrame source(long index) const {
    SourceFrame out;
    out.index = index;
    out.camera = scene.source;
    out.colour = &frame.colour;
    out.depth = &frame.depth;
    return out;
  }
};

struct NamedRasterizer {
  std::string name;
  std::unique_ptr<Rasterizer> rasterizer;
};

std::vector<NamedRasterizer> rasterizers(bool with_gl, ThreadPool& pool) {
  std::vector<NamedRasterizer> all;
  all.push_back({"cpu", make_cpu_rasterizer(pool)});
  if (!with_gl) return all;
  for (const GlOptions::Path path : {GlOptions::Path::compute, GlOptions::Path::sprites}) {
    try {
      auto rasterizer = make_gl_rasterizer(make_gl_context(GlBackend::automatic), {path});
      all.push_back({fmt::format("gl {}", to_string(path)), std::move(rasterizer)});
    } catch (const Error& error) {
      fmt::print(stderr, "gl {} left out: {}\n", to_string(path), error.what());
    }
  }
  return all;
}

std::string text(Size size) { return fmt::format("{}x{}", size.width, size.height); }

void measure_passes(const Workload& work, const std::vector<NamedRasterizer>& renderers, int runs, Table& table) {
  const double points = static_cast<double>(work.frame.depth.size().pixels());
  for (const NamedRasterizer& r : renderers) {
    ZBuffer zbuffer;
    ValidityMask covered;
    SoftSplat soft;
    const auto add = [&](const char* pass, const Timing& t) {
      table.add({r.name, text(work.frame.depth.size()), pass, t.median_ms, t.min_ms, points / t.median_ms / 1e3});
    };
    add("zbuffer", time(runs, [&] { r.rasterizer->zbuffer(work.grid(), work.target, {}, zbuffer); }));
    add("coverage", time(runs, [&] { r.rasterizer->coverage(work.grid(), work.target, {}, covered); }));
    add("soft_splat", time(runs, [&] { r.rasterizer->soft_splat(work.grid(), &work.colour, work.target, {}, soft); }));
  }
}

void measure_source_work(const Workload& work, ThreadPool& pool, int runs, Table& table) {
  const auto add = [&](const char* step, const Timing& t) {
    table.add({text(work.frame.depth.size()), step, t.median_ms, t.min_ms});
  };
  SlopeMap slopes;
  ValidityMask mask;
  const Intrinsics& lens = work.scene.source.intrinsics;
  add("slopes", time(runs, [&] { limited_slopes_from_depth(work.frame.depth, lens, {}, pool, slopes); }));
  add("reliable_depth", time(runs, [&] { reliable_depth(work.frame.depth, {}, pool, mask); }));
  add("front_mask", time(runs, [&] { front_mask(work.grid(), work.target, 0, pool, mask); }));
}

/// A new source index each frame: slopes and reliability are part of the time, as in a video.
void measure_algorithm(const Workload& work, const std::vector<NamedRasterizer>& renderers, ThreadPool& pool, int runs,
                       Table& table) {
  const double points = static_cast<double>(work.frame.depth.size().pixels());
  for (const NamedRasterizer& r : renderers)
    for (const Kernel kernel : {Kernel::nearest, Kernel::resample, Kernel::bilinear})
      for (const Visibility visibility : {Visibility::none, Visibility::ztest, Visibility::reproject}) {
        OcclusionOptions occlusion;
        occlusion.kernel = kernel;
        occlusion.visibility = visibility;
        occlusion.accumulation = Accumulation::none;
        occlusion.skip_unneeded = false;
        occlusion.reliability.enabled = true;  // the dearest case
        OcclusionRenderer renderer(*r.rasterizer, pool, occlusion);
        RenderedFrame out;
        FrameReport report;
        long index = 0;
        const Timing t = time(runs, [&] { report = renderer.render(work.source(index++), work.target, out); });
        table.add({r.name, text(work.frame.depth.size()), std::string(to_string(kernel)),
                   std::string(to_string(visibility)), report.passes, t.median_ms, t.min_ms,
                   points * report.passes / t.median_ms / 1e3});
      }
}

}  // namespace

void BenchOptions::check() const {
  std::vector<Size> all = sizes;
  all.push_back(size);
  for (const Size s : all)
    require(s.width >= 1 && s.height >= 1 && s.width <= 65535 && s.height <= 65535,
            "bench size {}x{} is outside 1..65535", s.width, s.height);
  require(runs >= 1 && runs <= 1000, "runs {} is outside 1..1000", runs);
  require(mvs_runs >= 1 && mvs_runs <= 100, "mvs_runs {} is outside 1..100", mvs_runs);
  require(start >= 0, "start {} is negative", start);
  require(stride >= 1, "stride {} is below 1", stride);
  require(threads >= 0, "threads {} is negative", threads);
  require(steps >= 1 && steps <= 1000, "steps {} is outside 1..1000", steps);
  for (const auto& [from, to] : pairs)
    require(from >= 0 && to >= 0 && from != to, "pair {}:{} is not two different frames counted from 0", from, to);
}

std::vector<Table> render_speed(const BenchOptions& options) {
  options.check();
  ThreadPool pool(options.threads);
  const std::vector<NamedRasterizer> renderers = rasterizers(options.gl, pool);
  Table source("per source frame", {"size", "step", "ms", "min_ms"});
  Table passes("one pass", {"renderer", "size", "pass", "ms", "min_ms", "mpoints_per_s"});
  Table algorithm("Algorithm 1, a new source frame each time",
                  {"renderer", "size", "kernel", "visibility", "passes", "ms_per_frame", "min_ms", "mpoints_per_s"});
  for (const Size size : options.sizes) {
    const Workload work(size, pool);
    measure_source_work(work, pool, options.runs, source);
    measure_passes(work, renderers, options.runs, passes);
    measure_algorithm(work, renderers, pool, options.runs, algorithm);
  }
  return {source, passes, algorithm};
}

}  // namespace uwv::bench
