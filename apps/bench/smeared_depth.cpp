// SPDX-License-Identifier: Apache-2.0
// What the reliability filter costs sharp depth and gains smeared depth: the reason it is on only where depth edges are
// smeared. Depth is blurred as a network's is, surfaces running into each other at silhouettes.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "bench/accuracy.h"
#include "uwv/eval/image_metrics.h"
#include "uwv/eval/wrong_surface.h"

namespace uwv::bench {
namespace {

/// Weights 1 2 1 along the rows, then along the columns, `times` times: a standard deviation of sqrt(times / 2) pixels.
DepthMap blurred(DepthMap depth, int times) {
  const Size size = depth.size();
  const auto clamped = [](int at, int count) { return std::clamp(at, 0, count - 1); };
  for (; times > 0; --times) {
    DepthMap rows(size);
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x)
        rows(x, y) = 0.25F * depth(clamped(x - 1, size.width), y) + 0.5F * depth(x, y) +
                     0.25F * depth(clamped(x + 1, size.width), y);
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x)
        depth(x, y) = 0.25F * rows(x, clamped(y - 1, size.height)) + 0.5F * rows(x, y) +
                      0.25F * rows(x, clamped(y + 1, size.height));
  }
  return depth;
}

struct Filter {
  std::string name;
  OcclusionOptions options;
};

std::vector<Filter> filters() {
  OcclusionOptions on = unfiltered();
  on.reliability.enabled = true;
  OcclusionOptions gone = on;
  gone.dropped_points_hide = false;
  OcclusionOptions small = on;
  small.reliability.window = 3;
  OcclusionOptions any_tilt = unfiltered();
  any_tilt.slopes.max_tilt = std::numbers::pi / 2;
  return {{"off", unfiltered()},
          {"off, max_tilt=90", any_tilt},
          {"on", on},
          {"on, window=3", small},
          {"on, dropped points gone", gone}};
}

double share(std::size_t part, const WrongSurface& of) {
  return of.valid > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(of.valid) : 0.0;
}

}  // namespace

Table smeared_depth_table(const Lab& lab) {
  Table table("smeared depth, one frame to each angle", {"degrees", "blur_px", "smeared_edges", "reliability", "psnr",
                                                         "valid", "wrong_%", "floating_%", "holes_%"});
  for (const double degrees : {5.0, 20.0, 45.0}) {
    const std::vector<Camera> camera = lab.orbit(degrees, 1).cameras;
    const MetricImage real(lab.view(camera.back()).colour);
    for (const int times : {0, 1, 2, 8}) {
      const DepthMap depth = blurred(lab.seen.depth, times);
      SourceFrame source = lab.source();
      source.depth = &depth;
      for (const Filter& filter : filters()) {
        const Followed end = follow(lab, filter.options, source, camera);
        const std::array<Camera, 1> sources{lab.scene.source};
        const WrongSurface wrong =
            wrong_surface(lab.scene.scene, 0, camera.back(), sources, end.frame.depth, end.frame.valid, lab.pool);
        table.add({degrees, std::sqrt(times / 2.0), edge_sharpness(depth, lab.pool).smeared_share(), filter.name,
                   psnr(MetricImage(end.frame.colour), real, &end.frame.valid), valid_share(end.frame.valid),
                   100 * wrong.wrong_share(), share(wrong.floating, wrong), 100 * wrong.hole_share()});
      }
    }
  }
  return table;
}

}  // namespace uwv::bench
