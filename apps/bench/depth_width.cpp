// SPDX-License-Identifier: Apache-2.0
// How many bits depth needs. Rounding moves a point little, but slopes are differences of neighbours; so there are rows
// with slopes from a larger neighbourhood as well.
#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <functional>

#include "bench/accuracy.h"
#include "uwv/eval/image_metrics.h"

namespace uwv::bench {
namespace {

struct Width {
  std::string name;
  std::function<float(float)> rounded;
  int slope_radius = 1;
};

float to_half(float z) { return static_cast<float>(static_cast<Eigen::half>(z)); }
float to_millimetres(float z) { return std::round(z * 1000.0F) / 1000.0F; }  // the unit of the scene taken for a metre

std::vector<Width> widths() {
  const auto exact = [](float z) { return z; };
  return {{"float32", exact},
          {"float32, slope radius=3", exact, 3},
          {"float16", to_half},
          {"float16, slope radius=3", to_half, 3},
          {"16-bit PNG, mm", to_millimetres},
          {"16-bit PNG, mm, slope radius=3", to_millimetres, 3}};
}

}  // namespace

Table depth_width_table(const Lab& lab, const BenchOptions& options) {
  Table table("width of depth",
              {"degrees", "depth", "M''_precision", "M''_recall", "Mvis_precision", "Mvis_recall", "valid", "psnr"});
  for (const double degrees : {20.0, 45.0, 90.0}) {
    const PathTruth path = lab.orbit(degrees, options.steps);
    const MetricImage real(lab.view(path.cameras.back()).colour);
    for (const Width& width : widths()) {
      DepthMap depth = lab.seen.depth;
      std::transform(depth.pixels().begin(), depth.pixels().end(), depth.pixels().begin(), width.rounded);
      SourceFrame source = lab.source();
      source.depth = &depth;
      OcclusionOptions occlusion = unfiltered();
      occlusion.slopes.radius = width.slope_radius;
      const Followed end = follow(lab, occlusion, source, path.cameras);
      const PrecisionRecall second = compare(end.masks.second, path.last),
                            visible = compare(end.masks.visible, path.product);
      table.add({degrees, width.name, second.precision(), second.recall(), visible.precision(), visible.recall(),
                 valid_share(end.frame.valid), psnr(MetricImage(end.frame.colour), real, &end.frame.valid)});
    }
  }
  return table;
}

}  // namespace uwv::bench
