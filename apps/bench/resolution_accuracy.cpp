// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "bench/accuracy.h"
#include "uwv/eval/image_metrics.h"

namespace uwv::bench {

// Judged at their own size: a smaller picture asks less of its pixels, and what it costs to enlarge it again is a
// question about enlarging.
Table resolution_table(const BenchOptions& options, ThreadPool& pool) {
  Table table("resolution", {"degrees", "size", "ms_per_frame", "M''_precision", "M''_recall", "Mvis_precision",
                             "Mvis_recall", "valid", "psnr"});
  for (const int divisor : {1, 2, 4}) {
    const Size size{std::max(1, options.size.width / divisor), std::max(1, options.size.height / divisor)};
    const Lab lab(scene_named(options.scene, size), pool);
    for (const double degrees : {20.0, 45.0, 90.0}) {
      const PathTruth path = lab.orbit(degrees, options.steps);
      const Followed end = follow(lab, unfiltered(), lab.source(), path.cameras);
      const PrecisionRecall second = compare(end.masks.second, path.last),
                            visible = compare(end.masks.visible, path.product);
      const MetricImage real(lab.view(path.cameras.back()).colour);
      table.add({degrees, fmt::format("{}x{}", size.width, size.height), end.ms, second.precision(), second.recall(),
                 visible.precision(), visible.recall(), valid_share(end.frame.valid),
                 psnr(MetricImage(end.frame.colour), real, &end.frame.valid)});
    }
  }
  return table;
}

}  // namespace uwv::bench
