// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "bench/accuracy.h"
#include "uwv/eval/image_metrics.h"

namespace uwv::bench {
namespace {

struct Way {
  std::string name;
  OcclusionOptions options;
};

std::vector<Way> ways() {
  std::vector<Way> all;
  const auto add = [&](std::string name, auto change) {
    OcclusionOptions options = unfiltered();
    change(options);
    all.push_back({std::move(name), options});
  };
  add("reproject", [](auto&) {});
  add("reproject, return_size=1", [](auto& o) { o.return_size = 1; });
  add("reproject, return_size=1.05", [](auto& o) { o.return_size = 1.05F; });
  add("reproject, return_size=1.2", [](auto& o) { o.return_size = 1.2F; });
  add("reproject, point_size=1.1", [](auto& o) { o.footprint.point_size = 1.1F; });
  add("reproject, point_size=1.15", [](auto& o) { o.footprint.point_size = 1.15F; });
  add("ztest", [](auto& o) { o.visibility = Visibility::ztest; });
  add("bilinear (official), product", [](auto& o) { o.kernel = Kernel::bilinear; });
  add("bilinear (official), foreground", [](auto& o) {
    o.kernel = Kernel::bilinear;
    o.accumulation = Accumulation::foreground;
  });
  add("reproject, foreground", [](auto& o) { o.accumulation = Accumulation::foreground; });
  return all;
}

/// The scene's first object, which in the stock scenes with a subject is the subject.
ValidityMask first_object(const SyntheticFrame& seen) {
  ValidityMask mask(seen.object.size());
  std::transform(seen.object.pixels().begin(), seen.object.pixels().end(), mask.pixels().begin(),
                 [](std::int32_t object) { return static_cast<std::uint8_t>(object == 0); });
  return mask;
}

}  // namespace

Table long_paths_table(const Lab& lab) {
  Table table("long paths",
              {"degrees", "frames", "options", "Mvis_precision", "Mvis_recall", "Mvis_f1", "valid", "psnr"});
  const ValidityMask foreground = first_object(lab.seen);
  SourceFrame source = lab.source();
  source.foreground = &foreground;
  for (const double degrees : {45.0, 90.0})
    for (const int frames : {8, 40, 81}) {
      const PathTruth path = lab.orbit(degrees, frames);
      const MetricImage real(lab.view(path.cameras.back()).colour);
      for (const Way& way : ways()) {
        const Followed end = follow(lab, way.options, source, path.cameras);
        const PrecisionRecall visible = compare(end.masks.visible, path.product);
        table.add({degrees, frames, way.name, visible.precision(), visible.recall(), visible.f1(),
                   valid_share(end.frame.valid), psnr(MetricImage(end.frame.colour), real, &end.frame.valid)});
      }
    }
  return table;
}

}  // namespace uwv::bench
