// SPDX-License-Identifier: Apache-2.0
// What structure from motion gains and loses when one of its options changes.
#include <utility>

#include "bench/geometry.h"
#include "bench/timing.h"

namespace uwv::bench {
namespace {

struct Variant {
  std::string name;
  SfmOptions options;
};

std::vector<Variant> variants() {
  std::vector<Variant> out{{"defaults", {}}};
  for (const int features : {500, 1000, 3000}) {
    out.push_back({fmt::format("max_features {}", features), {}});
    out.back().options.max_features = features;
  }
  for (const int height : {240, 360}) {
    out.push_back({fmt::format("tracking_height {}", height), {}});
    out.back().options.tracking_height = height;
  }
  for (const double error : {1.0, 4.0}) {
    out.push_back({fmt::format("max_error_px {}", error), {}});
    out.back().options.max_error_px = error;
  }
  return out;
}

}  // namespace

Table camera_option_table(const TrueClip& clip, ThreadPool& pool) {
  Table table("camera options of " + clip.name, {"changed", "lens", "result", "cameras", "ate", "ate_%", "rotation_deg",
                                                 "focal_%", "seconds", "processor_s"});
  Monitor monitor;
  for (Variant& variant : variants())
    for (const bool known : {true, false}) {
      if (known) variant.options.intrinsics = clip.cameras.front().intrinsics;
      if (!known) variant.options.intrinsics.reset();
      const Stopwatch watch;
      const SfmResult found = structure_from_motion(clip.frames, variant.options, pool, monitor);
      const double processor_seconds = watch.processor_seconds();
      const CameraScore score = score_cameras(found.cameras, found.registered, clip.cameras);
      table.add({variant.name, known ? "known" : "own", to_string(found.motion), score.cameras, figure(score.ate),
                 figure(score.ate_percent), figure(score.rotation_deg), figure(score.focal_percent), found.seconds,
                 processor_seconds});
    }
  return table;
}

}  // namespace uwv::bench
