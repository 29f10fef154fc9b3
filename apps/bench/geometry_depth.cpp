// SPDX-License-Identifier: Apache-2.0
#include "bench/geometry.h"

namespace uwv::bench {
namespace {

struct Variant {
  std::string name;
  MvsOptions options;
};

/// The default, and what changes when one option changes.
std::vector<Variant> variants() {
  std::vector<Variant> all{{"default", {}}};
  const auto add = [&](std::string name, auto change) {
    MvsOptions options;
    change(options);
    all.push_back({std::move(name), options});
  };
  for (const int stride : {1, 2, 4, 8})
    add(fmt::format("key_stride={}", stride), [&](MvsOptions& o) { o.key_stride = stride; });
  for (const double scale : {0.25, 1.0}) add(fmt::format("scale={}", scale), [&](MvsOptions& o) { o.scale = scale; });
  for (const int planes : {32, 128}) add(fmt::format("planes={}", planes), [&](MvsOptions& o) { o.planes = planes; });
  for (const int neighbours : {2, 8})
    add(fmt::format("neighbours={}", neighbours), [&](MvsOptions& o) { o.neighbours = neighbours; });
  add("complete=off", [](MvsOptions& o) { o.complete = false; });
  return all;
}

/// A row; `scale` as for score_depth().
void add_row(Table& table, const FoundClip& clip, const char* cameras_from, const Variant& variant,
             std::span<const Camera> cameras, std::span<const ScenePoint> points, double scale) {
  Monitor monitor;
  std::vector<FrameGeometry> found;
  const MvsSummary summary = multi_view_stereo(clip.truth.frames, cameras, points, clip.truth.static_pixels,
                                               variant.options, clip.pool, monitor, found);
  const DepthScore score = score_depth(found, clip.truth, scale);
  table.add({cameras_from, variant.name, summary.matched_frames, geometry_figure(score.abs_rel),
             geometry_figure(score.measured_abs_rel), geometry_figure(score.within_5), geometry_figure(score.within_25),
             geometry_figure(score.known), geometry_figure(score.measured), summary.seconds});
}

}  // namespace

Table depth_table(const FoundClip& clip) {
  Table table("depth of " + clip.truth.name, {"cameras", "option", "matched", "abs_rel", "abs_rel_measured",
                                              "within_5%", "within_25%", "known", "measured", "seconds"});
  const std::vector<ScenePoint> points = true_points(clip.truth);
  for (const Variant& variant : variants()) add_row(table, clip, "true", variant, clip.truth.cameras, points, 1);
  // A found scene has a scale of its own.
  const auto add_found = [&](const char* name, const SfmResult& found) {
    if (found.motion == ClipMotion::moving) add_row(table, clip, name, {"default", {}}, found.cameras, found.points, 0);
  };
  add_found("known focal", clip.known_focal);
  add_found("own focal", clip.own_focal);
  return table;
}

}  // namespace uwv::bench
