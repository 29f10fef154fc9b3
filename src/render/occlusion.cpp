// SPDX-License-Identifier: Apache-2.0
#include "uwv/render/occlusion.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include "render/accumulate.h"
#include "render/cells.h"
#include "render/kernel_chain.h"
#include "uwv/core/simd.h"

namespace uwv {
namespace {

constexpr const char* same_as_before = "same source frame and camera as the frame before";
constexpr const char* same_camera = "the target is the source camera: every point maps to its own pixel";
constexpr const char* no_parallax = "the camera only turns or zooms and keeps the whole picture: nothing can hide";
constexpr const char* nothing_hidden = "all points the first pass shows are kept: the last pass would repeat it";

/// True when every pixel of the source's picture stays inside the target's under a pure rotation or zoom. Straight
/// lines stay straight, so the corners decide.
bool keeps_whole_picture(const Camera& source, const Camera& target) {
  const Rigid3 motion = target_from_source(target, source);
  for (const double x : {0.0, static_cast<double>(source.size.width)})
    for (const double y : {0.0, static_cast<double>(source.size.height)}) {
      Eigen::Vector2d pixel;
      if (!project(target.intrinsics, motion.rotation * unproject(source.intrinsics, {x, y}, 1.0), pixel)) return false;
      if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > target.size.width || pixel.y() > target.size.height)
        return false;
    }
  return true;
}

void check_source(const SourceFrame& source) {
  require(source.colour != nullptr && source.depth != nullptr, "a source frame needs colour and depth");
  const Size size = source.camera.size;
  require(source.colour->size() == size, "the source picture is {}x{}, its camera {}x{}", source.colour->width(),
          source.colour->height(), size.width, size.height);
  for (const ValidityMask* mask : {source.valid, source.foreground})
    require(mask == nullptr || mask->size() == size, "a source mask does not have the picture's size {}x{}", size.width,
            size.height);
  PointGrid{source.camera, source.depth, source.slopes, source.valid, source.cells}.check();
}

/// Pixels of a row that are 1.
struct KeptOfRow {
  std::uint32_t reliable = 0, kept = 0;
};

UWV_SIMD_CLONES KeptOfRow keep_row(const std::uint8_t* reliable, const std::uint8_t* visible, const std::uint8_t* front,
                                   int width, std::uint8_t* keep) {
  KeptOfRow sum;
#pragma GCC ivdep  // inputs and outputs never overlap
  for (int x = 0; x < width; ++x) {
    const auto kept = static_cast<std::uint8_t>(reliable[x] & visible[x] & front[x]);
    keep[x] = kept;
    sum.reliable += reliable[x];
    sum.kept += kept;
  }
  return sum;
}

/// keep = reliable and visible and in front. Counts the reliable and the kept ones.
void combine(const ValidityMask& reliable, const ValidityMask& visible, const ValidityMask& front, ThreadPool& pool,
             ValidityMask& keep, FrameReport& report) {
  keep.resize(reliable.size());
  std::atomic<std::size_t> points{0}, drawn{0};
  pool.for_ranges(0, keep.height(), 64, [&](int from, int to) {
    std::size_t points_here = 0, drawn_here = 0;
    for (int y = from; y < to; ++y) {
      const KeptOfRow row = keep_row(reliable.row(y), visible.row(y), front.row(y), keep.width(), keep.row(y));
      points_here += row.reliable;
      drawn_here += row.kept;
    }
    points += points_here;
    drawn += drawn_here;
  });
  report.points = points;
  report.drawn = drawn;
}

/// The source's own picture where `keep` is 1.
void copy_kept(const SourceFrame& source, const ValidityMask& keep, RenderedFrame& out) {
  out.colour = *source.colour;
  out.depth = *source.depth;
  out.valid = keep;
  for (std::size_t i = 0; i < keep.size().pixels(); ++i) {
    if (keep.data()[i] != 0) continue;
    out.colour.data()[i] = {};
    out.depth.data()[i] = 0;
  }
}

}  // namespace

struct OcclusionRenderer::State {
  ThreadPool& pool;
  const OcclusionOptions options;
  std::unique_ptr<detail::KernelChain> chain;
  detail::VisibleSoFar visible;

  // Derived from the source frame, kept while the path stays on it.
  std::optional<long> source_index;
  SlopeMap slopes;
  ValidityMask reliable;

  // The last view, for paths that stand still: `keep` and the chain still hold what it was made of.
  std::optional<Camera> last_target;
  FrameReport last_report;
  bool last_was_copied = false;
  RenderedFrame still_frame;  // made by the first repetition: most paths never stand still

  ValidityMask second, front, keep;

  State(Rasterizer& rasterizer, ThreadPool& p, OcclusionOptions o)
      : pool(p), options(std::move(o)), visible(options.accumulation) {
    options.check();
    chain = options.kernel == Kernel::bilinear ? detail::make_soft_chain(rasterizer, pool, options)
                                               : detail::make_zbuffer_chain(rasterizer, pool, options);
  }

  void prepare_source(const SourceFrame& source) {
    if (source_index == source.index) return;
    source_index = source.index;
    last_target.reset();
    if (source.slopes == nullptr)
      limited_slopes_from_depth(*source.depth, source.camera.intrinsics, options.slopes, pool, slopes);
    if (source.valid == nullptr) reliable_depth(*source.depth, options.reliability, pool, reliable);
  }

  bool drops_front_points() const { return options.normal_filter && options.alpha < std::numbers::pi / 2; }

  /// Step 1: M_vis of this frame. Returns why nothing had to be rendered, or null.
  const char* accumulate(const SourceFrame& source, const PointGrid& points, const Camera& target, bool want_first,
                         FrameReport& report);
  void find_second(const SourceFrame& source, const PointGrid& points, const Camera& target, FrameReport& report);
  PointGrid grid(const SourceFrame& source, const ValidityMask* kept) const {
    return {source.camera, source.depth, source.slopes != nullptr ? source.slopes : &slopes, kept, source.cells};
  }
  /// The points of the first two passes.
  const ValidityMask* hiding(const SourceFrame& source) const {
    if (source.valid != nullptr) return source.valid;
    return options.dropped_points_hide && options.kernel != Kernel::bilinear ? nullptr : &reliable;
  }
  void show(const SourceFrame& source, const Camera& target, RenderedFrame& out);
  void run(const SourceFrame& source, const Camera& target, RenderedFrame& out, FrameMasks* masks, FrameReport& report);
};

/// M'' by the first two passes, into `second`.
void OcclusionRenderer::State::find_second(const SourceFrame& source, const PointGrid& points, const Camera& target,
                                           FrameReport& report) {
  ValidityMask landed;
  if (options.accumulation == Accumulation::foreground) {
    // The official recursion lets only background pixels come back: what the foreground lands on says nothing.
    require(source.foreground != nullptr, "Accumulation::foreground needs SourceFrame::foreground");
    ValidityMask moving = *source.foreground;
    if (points.keep != nullptr) intersect(moving, *points.keep);
    intersect(moving, front);
    PointGrid foreground = points;
    foreground.keep = &moving;
    chain->coverage(foreground, target, landed);
    ++report.passes;
  }
  chain->first(points, target);
  ++report.passes;
  chain->come_back(points, target, landed.empty() ? nullptr : &landed, second);
  report.passes += options.visibility == Visibility::reproject;
}

const char* OcclusionRenderer::State::accumulate(const SourceFrame& source, const PointGrid& points,
                                                 const Camera& target, bool want_first, FrameReport& report) {
  const bool naive = options.visibility == Visibility::none;
  const WarpMap map = WarpMap::between(source.camera, target);
  const bool skip = options.skip_unneeded && !want_first;
  const char* reason = nullptr;
  if (skip && map.identity) reason = same_camera;
  // The z-test hides points behind others that round to the same pixel even then, so it is not left out.
  else if (skip && options.visibility == Visibility::reproject && map.no_translation &&
           keeps_whole_picture(source.camera, target))
    reason = no_parallax;
  if (naive || reason != nullptr) {
    if (want_first) {
      chain->first(points, target);
      ++report.passes;
    }
    second.resize(source.camera.size);
    second.fill(1);
    visible.add_all(source.camera.size, source.foreground);
    return reason;
  }
  find_second(source, points, target, report);
  if (source.cells != nullptr) detail::spread_over_cells(*source.cells, *source.valid, pool, second);
  visible.add(second, points, target, source.foreground, pool);
  return nullptr;
}

/// The picture of the kept points.
void OcclusionRenderer::State::show(const SourceFrame& source, const Camera& target, RenderedFrame& out) {
  if (last_was_copied)
    copy_kept(source, keep, out);
  else
    chain->colour(source, grid(source, &keep), target, out);
}

void OcclusionRenderer::State::run(const SourceFrame& source, const Camera& target, RenderedFrame& out,
                                   FrameMasks* masks, FrameReport& report) {
  const ValidityMask& reliable_points = source.valid != nullptr ? *source.valid : reliable;
  const PointGrid points = grid(source, hiding(source));
  if (options.normal_filter) {
    front_mask(points, target, std::cos(options.alpha), pool, front);
  } else {
    front.resize(source.camera.size);
    front.fill(1);
  }
  const char* reason = accumulate(source, points, target, masks != nullptr, report);
  combine(reliable_points, visible.mask(), front, pool, keep, report);
  if (masks != nullptr) {
    chain->first_mask(masks->first);
    masks->second = second;
    masks->visible = visible.mask();
    masks->front = front;
  }
  last_was_copied =
      reason == same_camera && !drops_front_points() && options.kernel != Kernel::bilinear && source.cells == nullptr;
  if (!last_was_copied) {
    const bool after_first = options.skip_unneeded && report.passes > 0;
    const bool drawn = chain->draw(source, grid(source, &keep), target, after_first);
    report.passes += drawn;
    if (!drawn) reason = nothing_hidden;
  }
  show(source, target, out);
  if (reason != nullptr) report.skipped = reason;
}

OcclusionRenderer::OcclusionRenderer(Rasterizer& rasterizer, ThreadPool& pool, OcclusionOptions options)
    : state_(std::make_unique<State>(rasterizer, pool, std::move(options))) {}

OcclusionRenderer::~OcclusionRenderer() = default;

FrameReport OcclusionRenderer::render(const SourceFrame& source, const Camera& target, RenderedFrame& out,
                                      FrameMasks* masks) {
  const auto start = std::chrono::steady_clock::now();
  check_source(source);
  State& state = *state_;
  require(source.cells == nullptr ||
              (source.valid != nullptr && source.slopes != nullptr && state.options.kernel != Kernel::bilinear),
          "a decimated cloud needs its mask and slopes, and a kernel other than bilinear");
  state.prepare_source(source);
  FrameReport report;
  // Rendering the same view again cannot change M_vis either: the product is idempotent.
  if (state.options.skip_unneeded && masks == nullptr && state.last_target == target) {
    if (state.still_frame.valid.empty()) state.show(source, target, state.still_frame);
    out = state.still_frame;
    report = state.last_report;
    report.passes = 0;
    report.skipped = same_as_before;
  } else {
    state.run(source, target, out, masks, report);
    state.last_target = target;
    state.last_report = report;
    state.still_frame = {};
  }
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

void OcclusionRenderer::restart() {
  state_->visible.restart();
  state_->last_target.reset();
}

const OcclusionOptions& OcclusionRenderer::options() const { return state_->options; }

void OcclusionOptions::check() const {
  require(std::isfinite(alpha) && alpha >= 0 && alpha <= std::numbers::pi, "alpha {} rad is outside [0, pi]", alpha);
  require(tolerance() >= 0 && tolerance() < 1, "depth_tolerance {} is outside [0, 1)", tolerance());
  require(soft_splat.sharpness >= 0 && soft_splat.log_depth_max >= 0,
          "soft splat sharpness {} or log_depth_max {} is negative", soft_splat.sharpness, soft_splat.log_depth_max);
  require(return_size > 0 && return_size <= 4, "return_size {} is outside (0, 4]", return_size);
  require(fringe >= 0 && fringe <= 8, "fringe {} is outside 0..8 pixels", fringe);
  footprint.check();
  slopes.check();
  reliability.check();
}

}  // namespace uwv
