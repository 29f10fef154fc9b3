// SPDX-License-Identifier: Apache-2.0
#include "bench/geometry.h"
#include "bench/plot.h"
#include "bench/timing.h"
#include "uwv/geometry/moving_objects.h"
#include "uwv/geometry/scene_profile.h"

namespace uwv::bench {
namespace {

/// The default, what changes when one option changes, and both ends of what can be had.
std::vector<MvsVariant> variants() {
  std::vector<MvsVariant> all{{"default", {}}};
  const auto add = [&](std::string name, auto change) {
    MvsOptions options;
    change(options);
    all.push_back({std::move(name), options});
  };
  for (const int stride : {1, 2, 4, 8})
    add(fmt::format("key_stride={}", stride), [&](MvsOptions& o) { o.key_stride = stride; });
  for (const double scale : {0.25, 0.5, 1.0})
    add(fmt::format("scale={}", scale), [&](MvsOptions& o) { o.scale = scale; });
  for (const int planes : {32, 128}) add(fmt::format("planes={}", planes), [&](MvsOptions& o) { o.planes = planes; });
  for (const int neighbours : {2, 6, 8})
    add(fmt::format("neighbours={}", neighbours), [&](MvsOptions& o) { o.neighbours = neighbours; });
  add("complete=off", [](MvsOptions& o) { o.complete = false; });
  const auto add_all = [&](int stride, double scale, int planes, int neighbours) {
    add(fmt::format("key_stride={} scale={} planes={} neighbours={}", stride, scale, planes, neighbours),
        [&](MvsOptions& o) { o.key_stride = stride, o.scale = scale, o.planes = planes, o.neighbours = neighbours; });
  };
  add_all(8, 0.25, 32, 2);
  add_all(4, 0.5, 32, 2);
  add_all(2, 0.5, 64, 4);
  add_all(2, 0.75, 64, 8);
  add_all(1, 1.0, 128, 6);
  return all;
}

/// What the options cost and bring, drawn.
class Front {
 public:
  void add(const std::string& name, const MvsMeasured& measured, std::size_t frames) {
    const double cost = measured.processor_seconds / static_cast<double>(frames);
    const bool is_default = name == "default";
    depth_.dots.push_back({name, cost, measured.score.abs_rel, is_default});
    edges_.dots.push_back({name, cost, measured.score.edge_f, is_default});
  }
  void write(const std::string& path) const {
    write_plot(path, "seconds of one processor per frame", {depth_, edges_});
  }

 private:
  Panel depth_{"Depth over all pixels", "AbsRel", AxisScale::linear, {}, Better::low};
  Panel edges_{"Edges of depth", "F-score", AxisScale::linear, {}, Better::high};
};

/// True depth as if it had been found: its flicker says how well depth, lens and poses of a recording agree.
std::vector<FrameGeometry> as_found(const std::vector<DepthMap>& depths) {
  std::vector<FrameGeometry> out;
  for (const DepthMap& depth : depths) out.push_back({depth, ConfidenceMap(depth.size(), 1.0F)});
  return out;
}

}  // namespace

MvsMeasured measure_stereo(const TrueClip& clip, const MvsInput& input, const MvsOptions& options, double scale,
                           int runs, ThreadPool& pool) {
  MvsMeasured out;
  std::vector<FrameGeometry> found;
  std::vector<double> seconds, processor;
  Monitor monitor;
  for (int i = 0; i < runs; ++i) {
    const Stopwatch watch;
    out.summary =
        multi_view_stereo(clip.frames, input.cameras, input.points, input.static_pixels, options, pool, monitor, found);
    seconds.push_back(watch.seconds());
    processor.push_back(watch.processor_seconds());
  }
  out.seconds = median(std::move(seconds));
  out.processor_seconds = median(std::move(processor));
  out.score = score_depth(found, clip, scale);
  return out;
}

MvsMeasured measure_found(const FoundClip& clip, const SfmResult& cameras, int runs) {
  Monitor monitor;
  const MovingPixels moving = find_moving_pixels(clip.truth.frames, cameras.cameras, {}, {}, clip.pool, monitor);
  MvsInput input{cameras.cameras, cameras.points, {}};
  if (moving.moving_share > GeometryPlanOptions{}.min_layer_motion) input.static_pixels = moving.static_pixels;
  return measure_stereo(clip.truth, input, {}, 0, runs, clip.pool);
}

const std::vector<std::string>& depth_columns() {
  static const std::vector<std::string> columns{"abs_rel", "abs_rel_measured", "delta_125", "edge_f",  "flicker",
                                                "known",   "measured",         "scale",     "seconds", "cpu_s_frame"};
  return columns;
}

std::vector<nlohmann::ordered_json> depth_figures(const MvsMeasured& measured, std::size_t frames) {
  const DepthScore& score = measured.score;
  return {figure(score.abs_rel),   figure(score.measured_abs_rel),
          figure(score.delta_125), figure(score.edge_f),
          figure(score.flicker),   figure(score.known),
          figure(score.measured),  figure(score.scale),
          measured.seconds,        measured.processor_seconds / static_cast<double>(frames)};
}

Table depth_table(const FoundClip& clip, const BenchOptions& options) {
  std::vector<std::string> columns{"cameras", "option", "matched"};
  columns.insert(columns.end(), depth_columns().begin(), depth_columns().end());
  Table table("depth of " + clip.truth.name, columns);
  const std::size_t frames = clip.truth.frames.size();
  const auto add = [&](const char* cameras_from, const std::string& name, const MvsMeasured& measured) {
    std::vector<nlohmann::ordered_json> row{cameras_from, name, measured.summary.matched_frames};
    for (auto& value : depth_figures(measured, frames)) row.push_back(std::move(value));
    table.add(row);
  };
  MvsMeasured truth;
  truth.score = score_depth(as_found(clip.truth.depths), clip.truth, 1);
  add("true", "none: the truth itself", truth);
  const std::vector<ScenePoint> points = true_points(clip.truth);
  Front front;
  for (const MvsVariant& variant : variants()) {
    const MvsMeasured measured = measure_stereo(clip.truth, {clip.truth.cameras, points, clip.truth.static_pixels},
                                                variant.options, 0, options.mvs_runs, clip.pool);
    add("true", variant.name, measured);
    if (variant.options.complete) front.add(variant.name, measured, frames);
  }
  if (!options.plot.empty()) front.write(options.plot);
  const auto add_found = [&](const char* name, const SfmResult& found) {
    if (found.motion == ClipMotion::moving)
      add(name, "default", measure_found(clip, found, options.mvs_runs));
    else
      fmt::print("depth with cameras of {} left out: {}\n", name, found.reason);
  };
  add_found("known focal", clip.known_focal.result);
  add_found("own focal", clip.own_focal.result);
  return table;
}

}  // namespace uwv::bench
