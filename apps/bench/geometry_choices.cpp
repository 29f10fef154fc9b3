// SPDX-License-Identifier: Apache-2.0
// What the choices of plan_geometry() cost and bring: pictures of frames of a recording, made without those frames nor
// any that is nearer to them than the frame they are made from, against the real ones.
#include <cmath>
#include <cstdlib>

#include "bench/geometry.h"
#include "bench/timing.h"
#include "uwv/eval/depth_metrics.h"
#include "uwv/eval/image_metrics.h"
#include "uwv/geometry/decimation.h"
#include "uwv/render/other_views.h"

namespace uwv::bench {
namespace {

constexpr float measured = 0.5F;
constexpr long view_step = 3;  // uwv_app keeps a few dozen frames of a clip

/// Depth, confidence and cameras by one method; an empty list of confidences = all measured.
struct Geometry {
  std::string name;
  std::vector<Camera> cameras;
  std::vector<DepthMap> depths;
  std::vector<ConfidenceMap> confidences;
};

Geometry true_geometry(const TrueClip& clip) { return {"true depth", clip.cameras, clip.depths, {}}; }

Geometry stereo_geometry(const TrueClip& clip, const std::vector<Camera>& cameras, std::span<const ScenePoint> points,
                         int key_stride, ThreadPool& pool, MvsSummary& summary) {
  Monitor monitor;
  MvsOptions options;
  options.key_stride = key_stride;
  std::vector<FrameGeometry> frames;
  summary = multi_view_stereo(clip.frames, cameras, points, clip.static_pixels, options, pool, monitor, frames);
  Geometry out{fmt::format("stereo, every {}", key_stride), cameras, {}, {}};
  for (FrameGeometry& frame : frames) {
    out.depths.push_back(std::move(frame.depth));
    out.confidences.push_back(std::move(frame.confidence));
  }
  return out;
}

ValidityMask usable(const TrueClip& clip, const Geometry& geometry, std::size_t index) {
  ValidityMask mask(geometry.depths[index].size(), 1);
  if (!geometry.confidences.empty())
    std::transform(geometry.confidences[index].pixels().begin(), geometry.confidences[index].pixels().end(),
                   mask.pixels().begin(), [](float c) { return static_cast<std::uint8_t>(c >= measured); });
  if (!clip.static_pixels.empty()) intersect(mask, clip.static_pixels[index]);
  return mask;
}

SourceFrame frame_of(const TrueClip& clip, const std::vector<Camera>& cameras, const std::vector<DepthMap>& depths,
                     std::size_t index) {
  SourceFrame source;
  source.index = static_cast<long>(index);
  source.camera = cameras[index];
  source.colour = &clip.frames[index];
  source.depth = &depths[index];
  return source;
}

SourceFrame frame_of(const TrueClip& clip, const Geometry& geometry, std::size_t index) {
  return frame_of(clip, geometry.cameras, geometry.depths, index);
}

/// Frames that may help with `target` when it is made from `source`.
std::vector<std::size_t> helpers(std::size_t frames, std::size_t source, std::size_t target) {
  std::vector<std::size_t> all;
  const auto distance = [&](std::size_t i) { return std::labs(static_cast<long>(i) - static_cast<long>(target)); };
  for (std::size_t i = 0; i < frames; i += view_step)
    if (distance(i) >= distance(source) && i != source) all.push_back(i);
  return all;
}

/// All points in one z-buffer: of several frames the nearest wins, whichever it is of.
void put_nearest(const RenderedFrame& from, RenderedFrame& into) {
  for (std::size_t i = 0; i < into.valid.pixels().size(); ++i) {
    if (from.valid.pixels()[i] == 0) continue;
    if (into.valid.pixels()[i] != 0 && into.depth.pixels()[i] <= from.depth.pixels()[i]) continue;
    into.colour.pixels()[i] = from.colour.pixels()[i];
    into.depth.pixels()[i] = from.depth.pixels()[i];
    into.valid.pixels()[i] = 1;
  }
}

/// Means over the pairs of frames.
struct Score {
  double psnr = 0, valid = 0, psnr_new = 0, ms = 0, views = 0;
  int pairs = 0, with_new = 0;

  void add(const RenderedFrame& frame, const ValidityMask& before, const MetricImage& truth, double milliseconds) {
    const MetricImage picture(frame.colour);
    psnr += uwv::psnr(picture, truth, &frame.valid);
    valid += valid_share(frame.valid);
    ms += milliseconds;
    ++pairs;
    ValidityMask added = frame.valid;
    for (std::size_t i = 0; i < added.pixels().size(); ++i) added.pixels()[i] &= before.pixels()[i] == 0 ? 1U : 0U;
    if (added.count() < 100) return;
    psnr_new += uwv::psnr(picture, truth, &added);
    ++with_new;
  }
  void row(Table& table, const std::string& geometry, const std::string& cloud) const {
    table.add({geometry, cloud, psnr / pairs, valid / pairs, figure(with_new > 0 ? psnr_new / with_new : std::nan("")),
               ms / pairs, views / pairs});
  }
};

class CloudTable {
 public:
  CloudTable(const TrueClip& clip, const BenchOptions& options, ThreadPool& pool)
      : table("clouds of " + clip.name, {"geometry", "cloud", "psnr", "valid", "psnr_new", "ms_frame", "views"}),
        clip_(clip),
        options_(options),
        pool_(pool),
        rasterizer_(make_cpu_rasterizer(pool)) {}

  void add(const Geometry& geometry) {
    Score per_frame, merged, one_cloud;
    for (const auto& [from, to] : options_.pairs) {
      const auto frames = static_cast<long>(clip_.frames.size());
      if (from < 0 || to < 0 || from >= frames || to >= frames) continue;
      compare(geometry, static_cast<std::size_t>(from), static_cast<std::size_t>(to), per_frame, merged, one_cloud);
    }
    per_frame.row(table, geometry.name, "per_frame");
    merged.row(table, geometry.name, "merged");
    one_cloud.row(table, geometry.name, "all points at once");
  }

  Table table;

 private:
  void compare(const Geometry& geometry, std::size_t from, std::size_t to, Score& per_frame, Score& merged,
               Score& one_cloud) {
    const MetricImage truth(clip_.frames[to]);
    const Camera& target = geometry.cameras[to];
    OcclusionOptions occlusion;
    occlusion.accumulation = Accumulation::none;
    RenderedFrame own;
    const FrameReport report =
        OcclusionRenderer(*rasterizer_, pool_, occlusion).render(frame_of(clip_, geometry, from), target, own);
    only_static(own, to);
    per_frame.add(own, own.valid, truth, 1000 * report.seconds);

    const std::vector<std::size_t> others = helpers(clip_.frames.size(), from, to);
    RenderedFrame filled = own;
    OtherViews views(*rasterizer_, pool_, occlusion, {});
    for (const std::size_t i : others)
      views.add(
          {static_cast<long>(i), geometry.cameras[i], clip_.frames[i], geometry.depths[i], usable(clip_, geometry, i)});
    const FillReport fill = views.fill(frame_of(clip_, geometry, from), target, filled);
    only_static(filled, to);
    merged.views += fill.views;
    merged.add(filled, own.valid, truth, 1000 * (report.seconds + fill.seconds));

    RenderedFrame all = own;
    double seconds = report.seconds;
    for (const std::size_t i : others) {
      SourceFrame source = frame_of(clip_, geometry, i);
      const ValidityMask mask = usable(clip_, geometry, i);
      source.valid = &mask;
      RenderedFrame picture;
      seconds += OcclusionRenderer(*rasterizer_, pool_, occlusion).render(source, target, picture).seconds;
      put_nearest(picture, all);
    }
    only_static(all, to);
    one_cloud.views += static_cast<double>(others.size());
    one_cloud.add(all, own.valid, truth, 1000 * seconds);
  }

  void only_static(RenderedFrame& frame, std::size_t index) const {
    if (!clip_.static_pixels.empty()) intersect(frame.valid, clip_.static_pixels[index]);
  }

  const TrueClip& clip_;
  const BenchOptions& options_;
  ThreadPool& pool_;
  std::unique_ptr<Rasterizer> rasterizer_;
};

/// A frame with fewer points where it is flat, as uwv_app draws it.
class PointTable {
 public:
  PointTable(const TrueClip& clip, const BenchOptions& options, ThreadPool& pool)
      : table("points of " + clip.name, {"max_error", "points", "ms_find", "ms_draw", "psnr", "valid"}),
        clip_(clip),
        options_(options),
        pool_(pool),
        rasterizer_(make_cpu_rasterizer(pool)) {}

  void add(double max_error) {
    double points = 0, find = 0, draw = 0, db = 0, valid = 0;
    int pairs = 0;
    for (const auto& [from, to] : options_.pairs) {
      const auto frames = static_cast<long>(clip_.frames.size());
      if (from < 0 || to < 0 || from >= frames || to >= frames) continue;
      const auto source = static_cast<std::size_t>(from), target = static_cast<std::size_t>(to);
      Thinned thinned;
      if (max_error > 0) find += time(options_.runs, [&] { thinned = thin(source, target, max_error); }).median_ms;
      OcclusionOptions occlusion;
      occlusion.accumulation = Accumulation::none;
      RenderedFrame picture;
      draw +=
          time(options_.runs, [&] {
            OcclusionRenderer renderer(*rasterizer_, pool_, occlusion);
            renderer.render(max_error > 0 ? thinned.of(frame(source)) : frame(source), clip_.cameras[target], picture);
          }).median_ms;
      db += psnr(MetricImage(picture.colour), MetricImage(clip_.frames[target]), &picture.valid);
      valid += valid_share(picture.valid);
      points += max_error > 0 ? thinned.share : 1;
      ++pairs;
    }
    table.add({max_error, points / pairs, find / pairs, draw / pairs, db / pairs, valid / pairs});
  }

  Table table;

 private:
  struct Thinned {
    DepthMap depth;
    SlopeMap slopes;
    ValidityMask kept;
    Image<std::uint8_t> cells;
    double share = 0;
    SourceFrame of(SourceFrame source) const {
      source.depth = &depth;
      source.slopes = &slopes;
      source.valid = &kept;
      source.cells = &cells;
      return source;
    }
  };

  SourceFrame frame(std::size_t index) const { return frame_of(clip_, clip_.cameras, clip_.depths, index); }

  Thinned thin(std::size_t from, std::size_t to, double max_error) {
    DecimationOptions options;
    options.max_error = max_error;
    const Camera& camera = clip_.cameras[from];
    DecimatedDepth found = decimate_depth(clip_.depths[from], camera, std::span(&clip_.cameras[to], 1), options, pool_);
    Thinned out{clip_.depths[from], {}, std::move(found.kept), std::move(found.cell), found.kept_share};
    limited_slopes_from_depth(clip_.depths[from], camera.intrinsics, {}, pool_, out.slopes);
    for (std::size_t i = 0; i < out.cells.pixels().size(); ++i)
      if (out.cells.pixels()[i] > 1) {
        out.depth.pixels()[i] = found.depth.pixels()[i];
        out.slopes.pixels()[i] = found.slopes.pixels()[i];
      }
    return out;
  }

  const TrueClip& clip_;
  const BenchOptions& options_;
  ThreadPool& pool_;
  std::unique_ptr<Rasterizer> rasterizer_;
};

/// Mean relative error of all depths, after nothing: cameras are true.
double abs_rel(const TrueClip& clip, const Geometry& geometry) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t f = 0; f < clip.depths.size(); ++f)
    for (std::size_t i = 0; i < clip.depths[f].pixels().size(); ++i) {
      const auto truth = static_cast<double>(clip.depths[f].pixels()[i]);
      const auto found = static_cast<double>(geometry.depths[f].pixels()[i]);
      if (!(truth > 0) || !(found > 0)) continue;
      sum += std::abs(found / truth - 1);
      ++count;
    }
  return count > 0 ? sum / static_cast<double>(count) : std::nan("");
}

}  // namespace

std::vector<Table> choice_tables(const TrueClip& clip, const BenchOptions& options, ThreadPool& pool) {
  CloudTable clouds(clip, options, pool);
  clouds.add(true_geometry(clip));
  Table strides("key frames of " + clip.name, {"stride", "matched", "measured", "abs_rel", "seconds"});
  const std::vector<ScenePoint> points = true_points(clip);
  for (const int stride : {1, 2, 4, 8}) {
    MvsSummary summary;
    const Geometry found = stereo_geometry(clip, clip.cameras, points, stride, pool, summary);
    strides.add({stride, summary.matched_frames, summary.measured_share, abs_rel(clip, found), summary.seconds});
    clouds.add(found);
  }
  PointTable points_kept(clip, options, pool);
  for (const double max_error : {0.0, 0.25, 0.5, 1.0, 2.0}) points_kept.add(max_error);
  return {clouds.table, strides, points_kept.table};
}

}  // namespace uwv::bench
