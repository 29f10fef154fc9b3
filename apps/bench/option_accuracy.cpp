// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <map>
#include <numbers>

#include "bench/accuracy.h"
#include "bench/plot.h"
#include "bench/timing.h"
#include "uwv/eval/image_metrics.h"
#include "uwv/eval/wrong_surface.h"

namespace uwv::bench {
namespace {

struct Variant {
  std::string name;
  OcclusionOptions options;
};

/// The default and what changes when one option changes.
std::vector<Variant> variants() {
  const OcclusionOptions base = unfiltered();
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
  add("reliability=on, dropped points gone", [](auto& o) {
    o.reliability.enabled = true;
    o.dropped_points_hide = false;
  });
  add("return_size=1", [](auto& o) { o.return_size = 1; });
  add("fringe=1", [](auto& o) { o.fringe = 1; });
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

/// What the picture of all options shows of one.
struct Summary {
  std::vector<double> ms;  ///< At each angle.
  double f1 = 0;           ///< Of M_vis at 90 degrees.
  double psnr = 0;         ///< At 45 degrees.
  double holes = 0;        ///< Per cent there of the pixels that could be known.
};

void plot(const std::string& path, const std::map<std::string, Summary>& summaries) {
  Panel masks{"Which points are visible, after an orbit of 90 degrees", "F1 of M_vis", AxisScale::nines, {}};
  Panel picture{"The picture, after an orbit of 45 degrees", "PSNR over drawn pixels, dB", AxisScale::linear, {}};
  for (const auto& [name, summary] : summaries) {
    const double ms = median(summary.ms);
    const bool accent = name == "default";
    masks.dots.push_back({name, ms, summary.f1, accent});
    // Who draws only the easy pixels has a high PSNR; the label says so.
    const std::string caveat = summary.holes > 10 ? fmt::format(" ({:.0f} % holes)", summary.holes) : "";
    picture.dots.push_back({name + caveat, ms, summary.psnr, accent});
  }
  write_plot(path, "milliseconds per frame", {masks, picture});
}

}  // namespace

Table option_table(const Lab& lab, const BenchOptions& options) {
  constexpr std::array<double, 5> angles{5, 20, 45, 70, 90};
  Table table(fmt::format("{}, {} frames to each angle", lab.scene.name, options.steps),
              {"degrees", "options", "ms_per_frame", "M''_precision", "M''_recall", "Mvis_precision", "Mvis_recall",
               "valid", "wrong_%", "unknowable_%", "holes_%", "psnr"});
  const std::array<Camera, 1> sources{lab.scene.source};
  std::map<std::string, Summary> summaries;
  for (const double degrees : angles) {
    const PathTruth path = lab.orbit(degrees, options.steps);
    const MetricImage real(lab.view(path.cameras.back()).colour);
    for (const Variant& variant : variants()) {
      const Followed end = follow(lab, variant.options, lab.source(), path.cameras);
      const PrecisionRecall second = compare(end.masks.second, path.last),
                            visible = compare(end.masks.visible, path.product);
      const WrongSurface wrong =
          wrong_surface(lab.scene.scene, 0, path.cameras.back(), sources, end.frame.depth, end.frame.valid, lab.pool);
      const double unknowable =
          wrong.valid > 0 ? 100.0 * static_cast<double>(wrong.through_unknown) / static_cast<double>(wrong.valid) : 0.0;
      const double db = psnr(MetricImage(end.frame.colour), real, &end.frame.valid);
      table.add({degrees, variant.name, end.ms, second.precision(), second.recall(), visible.precision(),
                 visible.recall(), valid_share(end.frame.valid), 100 * wrong.wrong_share(), unknowable,
                 100 * wrong.hole_share(), db});
      Summary& summary = summaries[variant.name];
      summary.ms.push_back(end.ms);
      if (degrees == 90) summary.f1 = visible.f1();
      if (degrees == 45) summary.psnr = db, summary.holes = 100 * wrong.hole_share();
    }
  }
  if (!options.plot.empty()) plot(options.plot, summaries);
  return table;
}

}  // namespace uwv::bench
