// SPDX-License-Identifier: Apache-2.0
// Renderings from where a second real picture was taken, against that picture.
//
// Compared are the pixels a rendering shows (its valid pixels) with the second picture as it is: moving highlights,
// noise and exposure included, and whether or not the second camera's depth is known there. `psnr_common` and
// `ssim_common` take only the pixels that all rows of a pair and table (and reliability setting, where the table has
// both) show, so that nobody gains by showing less; `psnr_more` takes the pixels a row shows beyond those.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <span>

#include "bench/benchmarks.h"
#include "bench/real_pairs.h"
#include "bench/timing.h"
#include "uwv/eval/image_metrics.h"
#include "uwv/render/occlusion.h"

namespace uwv::bench {
namespace {

struct Method {
  std::string name;
  OcclusionOptions options;
  bool along_path = false;  ///< M_vis is the product over the whole way to the second camera, not over it alone.
};

OcclusionOptions with_reliability(bool enabled) {
  OcclusionOptions options;
  options.reliability.enabled = enabled;
  return options;
}

/// Who is compared with whom. A single view has nothing to accumulate: product and none are the same there.
std::vector<Method> methods(bool reliability) {
  std::vector<Method> all;
  const auto add = [&](std::string name, Kernel kernel, Visibility visibility) {
    OcclusionOptions options = with_reliability(reliability);
    options.kernel = kernel;
    options.visibility = visibility;
    options.normal_filter = visibility != Visibility::none;
    all.push_back({std::move(name), options});
  };
  add("naive (nearest)", Kernel::nearest, Visibility::none);
  add("naive (resample)", Kernel::resample, Visibility::none);
  add("naive (bilinear)", Kernel::bilinear, Visibility::none);
  add("official (bilinear)", Kernel::bilinear, Visibility::reproject);
  add("ours", Kernel::resample, Visibility::reproject);
  add("ours, nearest", Kernel::nearest, Visibility::reproject);
  add("ours, ztest", Kernel::resample, Visibility::ztest);
  // As many pixels as the official kernel shows, for a comparison at equal share.
  add("ours, fringe=1", Kernel::resample, Visibility::reproject);
  all.back().options.fringe = 1;
  return all;
}

/// The default, and what changes when one option changes.
std::vector<Method> footprints_and_paths() {
  const OcclusionOptions base = with_reliability(false);
  std::vector<Method> all{{"default", base}};
  const auto add = [&](std::string name, auto change, bool along_path = false) {
    OcclusionOptions options = base;
    change(options);
    all.push_back({std::move(name), options, along_path});
  };
  for (const float size : {0.7F, 1.1F, 1.15F})
    add(fmt::format("point_size={}", size), [&](auto& o) { o.footprint.point_size = size; });
  for (const float side : {1.0F, 4.0F, 64.0F})
    add(fmt::format("max_footprint={}", side), [&](auto& o) { o.footprint.max_footprint = side; });
  add("max_tilt=90", [](auto& o) { o.slopes.max_tilt = std::numbers::pi / 2; });
  add("normal_filter=off", [](auto& o) { o.normal_filter = false; });
  add(
      "along the path", [](auto&) {}, true);
  add(
      "along the path, ztest", [](auto& o) { o.visibility = Visibility::ztest; }, true);
  add(
      "along the path, point_size=1.15", [](auto& o) { o.footprint.point_size = 1.15F; }, true);
  add(
      "along the path, official (bilinear)", [](auto& o) { o.kernel = Kernel::bilinear; }, true);
  return all;
}

std::vector<Method> reliability_ratios() {
  std::vector<Method> all;
  for (const Kernel kernel : {Kernel::resample, Kernel::bilinear})
    for (const float ratio : {0.1F, 0.2F, 0.3F, 0.5F}) {
      OcclusionOptions options = with_reliability(true);
      options.kernel = kernel;
      options.reliability.ratio = ratio;
      all.push_back({fmt::format("{}, ratio={}", to_string(kernel), ratio), options});
    }
  OcclusionOptions small_window = with_reliability(true);
  small_window.reliability.window = 3;
  all.push_back({"resample, ratio=0.1, window=3", small_window});
  OcclusionOptions gone = with_reliability(true);
  gone.dropped_points_hide = false;
  all.push_back({"resample, ratio=0.1, dropped points gone", gone});
  return all;
}

struct Rendering {
  RenderedFrame frame;
  double ms = 0;  ///< Per frame, source work included.
};

Rendering render(const RealPair& pair, const Method& method, Rasterizer& rasterizer, ThreadPool& pool, int runs) {
  OcclusionRenderer renderer(rasterizer, pool, method.options);
  SourceFrame source;
  source.camera = pair.source;
  source.colour = &pair.colour;
  source.depth = &pair.depth;
  const std::span<const Camera> path = method.along_path ? std::span(pair.path) : std::span(pair.path).last(1);
  Rendering out;
  const Timing timing = time(runs, [&] {
    renderer.restart();
    for (const Camera& camera : path) {
      ++source.index;  // as in a video: everything is computed for every frame
      renderer.render(source, camera, out.frame);
    }
  });
  out.ms = timing.median_ms / static_cast<double>(path.size());
  return out;
}

/// Per cent of the pixels shown that lie behind everything the second camera measured within a pixel: there the
/// rendering shines through something real. 2 % covers the depth camera's own error. Pixels without a measurement are
/// not judged.
double shown_through(const RenderedFrame& frame, const DepthMap& truth) {
  constexpr float tolerance = 0.02F;
  std::size_t judged = 0, behind = 0;
  for (int y = 1; y + 1 < truth.height(); ++y)
    for (int x = 1; x + 1 < truth.width(); ++x) {
      if (frame.valid(x, y) == 0) continue;
      float nearest = truth(x, y), farthest = nearest;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          nearest = std::min(nearest, truth(x + dx, y + dy));
          farthest = std::max(farthest, truth(x + dx, y + dy));
        }
      if (nearest <= 0) continue;  // not measured all around
      ++judged;
      behind += frame.depth(x, y) > (1 + tolerance) * farthest;
    }
  return judged > 0 ? 100.0 * static_cast<double>(behind) / static_cast<double>(judged) : 0.0;
}

ValidityMask beyond(const ValidityMask& mask, const ValidityMask& common) {
  ValidityMask rest(mask.size());
  std::transform(mask.pixels().begin(), mask.pixels().end(), common.pixels().begin(), rest.pixels().begin(),
                 [](std::uint8_t all, std::uint8_t part) { return static_cast<std::uint8_t>(all & ~part); });
  return rest;
}

const std::vector<std::string> columns{"pair",        "method",      "reliability", "psnr",      "valid",
                                       "psnr_common", "ssim_common", "psnr_more",   "through_%", "ms"};

/// Renders a pair by every method and adds a row each; all of them are compared on the pixels they share.
void compare(const RealPair& pair, const std::vector<Method>& methods, Rasterizer& rasterizer, ThreadPool& pool,
             int runs, Table& table) {
  std::vector<Rendering> renderings;
  renderings.reserve(methods.size());
  for (const Method& method : methods) renderings.push_back(render(pair, method, rasterizer, pool, runs));
  ValidityMask common = renderings.front().frame.valid;
  for (const Rendering& rendering : renderings) intersect(common, rendering.frame.valid);

  const MetricImage truth(pair.truth);
  for (std::size_t i = 0; i < methods.size(); ++i) {
    const RenderedFrame& frame = renderings[i].frame;
    const MetricImage picture(frame.colour);
    const ValidityMask more = beyond(frame.valid, common);
    table.add({pair.name, methods[i].name, methods[i].options.reliability.enabled ? "on" : "off",
               figure(psnr(picture, truth, &frame.valid)), valid_share(frame.valid),
               figure(psnr(picture, truth, &common)), figure(ssim(picture, truth, &common)),
               figure(psnr(picture, truth, &more)),
               pair.truth_depth.empty() ? nlohmann::ordered_json("-") : figure(shown_through(frame, pair.truth_depth)),
               renderings[i].ms});
  }
}

std::vector<RealPair> find_pairs(const BenchOptions& options) {
  ResizePolicy resize;
  if (options.no_resize) resize.mode = ResizePolicy::Mode::none;
  std::vector<RealPair> pairs;
  if (std::filesystem::exists(options.motorcycle + "/motorcycle_left.png"))
    pairs.push_back(motorcycle_pair(options.motorcycle, resize));
  else
    fmt::print("motorcycle left out: {}/motorcycle_left.png does not exist; scripts/setup fetches it\n",
               options.motorcycle);
  if (options.rgbd.empty())
    fmt::print("rgbd left out: no recording given with --rgbd\n");
  else
    for (RealPair& pair : rgbd_pairs(options.rgbd, options.pairs, resize)) pairs.push_back(std::move(pair));
  if (pairs.empty()) fail(ErrorCode::file_not_found, "no real pair to compare: give --motorcycle or --rgbd");
  return pairs;
}

}  // namespace

std::vector<Table> real_views(const BenchOptions& options) {
  options.check();
  ThreadPool pool(options.threads);
  const auto rasterizer = make_cpu_rasterizer(pool);
  Table who("real second views", columns), what("real second views: footprints and paths", columns),
      reliability("real second views: reliability ratio", columns);
  for (const RealPair& pair : find_pairs(options)) {
    for (const bool filtered : {false, true}) compare(pair, methods(filtered), *rasterizer, pool, options.runs, who);
    compare(pair, footprints_and_paths(), *rasterizer, pool, options.runs, what);
    compare(pair, reliability_ratios(), *rasterizer, pool, options.runs, reliability);
  }
  return {who, what, reliability};
}

}  // namespace uwv::bench
