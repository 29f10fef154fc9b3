// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "bench/accuracy.h"
#include "bench/timing.h"

namespace uwv::bench {
namespace {

struct Situation {
  std::string name;
  Camera before, now;
};

/// The cases docs/rendering.md lists, and one where nothing can be left out.
std::vector<Situation> situations(const StockScene& scene) {
  constexpr double degree = std::numbers::pi / 180;
  const Camera start = scene.source;
  const Camera aside = orbit_camera(start, scene.subject_in_world, 20 * degree);
  Camera turned = start;  // the wider lens keeps the whole picture
  turned.intrinsics.fx *= 0.7;
  turned.intrinsics.fy *= 0.7;
  turned.world_from_cam.rotation =
      start.world_from_cam.rotation * Eigen::AngleAxisd(5 * degree, Eigen::Vector3d::UnitY()).toRotationMatrix();
  return {{"the camera stands still", aside, aside},
          {"the target is the source camera", aside, start},
          {"the camera only turns, the picture stays in view", aside, turned},
          {"the camera backs off: nothing gets hidden", aside, approach_camera(start, scene.subject_in_world, 1.25)},
          {"orbit of 20 degrees", start, aside}};
}

struct Outcome {
  RenderedFrame frame;
  FrameReport report;
  double ms = 0;
};

/// The second of two frames. The first one makes it the middle of a path and pays for the source frame.
Outcome second_frame(const Lab& lab, const OcclusionOptions& options, const Situation& situation, int runs) {
  Outcome out;
  std::vector<double> ms;
  for (int run = 0; run < runs; ++run) {
    OcclusionRenderer renderer(*lab.rasterizer, lab.pool, options);
    renderer.render(lab.source(), situation.before, out.frame);
    out.report = renderer.render(lab.source(), situation.now, out.frame);
    ms.push_back(out.report.seconds * 1e3);
  }
  out.ms = median(std::move(ms));
  return out;
}

/// What leaving out passes changed. A depth that went through a warp, even one onto itself, is rounded.
std::string difference(const RenderedFrame& a, const RenderedFrame& b) {
  if (a.colour != b.colour || a.valid != b.valid) return "no";
  double largest = 0;
  for (std::size_t i = 0; i < a.depth.size().pixels(); ++i) {
    const double one = a.depth.data()[i], other = b.depth.data()[i];
    if (one != other) largest = std::max(largest, std::abs(one - other) / std::max(one, other));
  }
  return largest == 0 ? "yes" : fmt::format("yes; depth to {:.0e}", largest);
}

}  // namespace

Table skipped_passes_table(const Lab& lab, const BenchOptions& options) {
  Table table("passes left out",
              {"path", "visibility", "passes", "passes_without_skipping", "ms", "ms_without_skipping", "identical"});
  for (const Situation& situation : situations(lab.scene))
    for (const Visibility visibility : {Visibility::reproject, Visibility::ztest}) {
      OcclusionOptions occlusion = unfiltered();
      occlusion.visibility = visibility;
      occlusion.accumulation = Accumulation::none;  // what the first frame hid must not count here
      const Outcome with = second_frame(lab, occlusion, situation, options.runs);
      occlusion.skip_unneeded = false;
      const Outcome without = second_frame(lab, occlusion, situation, options.runs);
      table.add({situation.name, std::string(to_string(visibility)), with.report.passes, without.report.passes, with.ms,
                 without.ms, difference(with.frame, without.frame)});
    }
  return table;
}

}  // namespace uwv::bench
