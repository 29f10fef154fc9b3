// SPDX-License-Identifier: Apache-2.0
#include "uwv/render/other_views.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <optional>
#include <vector>

#include "render/surface.h"
#include "render/view_choice.h"

namespace uwv {
namespace {

/// Where depth steps, colours are mixed and measured depth is least sure; another view shows those places better.
constexpr ReliabilityOptions away_from_edges{.enabled = true, .window = 3, .ratio = 0.1F, .count_padding = false};

/// A view with what is derived from it once.
struct PreparedView {
  OtherView view;
  SlopeMap slopes;
  PointGrid grid() const { return {view.camera, &view.depth, &slopes, &view.usable}; }
};

/// Whether a frame looks through points: it measured something behind them.
class SeesThrough {
 public:
  /// `usable` may be null; the pointers outlive the object.
  SeesThrough(const Camera& camera, const Camera& target, const DepthMap& depth, const ValidityMask* usable)
      : map_(WarpMap::between(target, camera)), depth_(&depth), usable_(usable) {}

  /// The point at target pixel (x, y) with depth z there. The least depth around counts: at an edge of depth half a
  /// pixel decides nothing.
  bool operator()(int x, int y, float z, float tolerance) const {
    const WarpMap::Landing landing = map_.apply(x, y, z);
    if (!landing.inside(depth_->size())) return false;
    const int u = static_cast<int>(landing.u), v = static_cast<int>(landing.v);
    float least = 0;
    for (int j = std::max(0, v - 1); j <= std::min(depth_->height() - 1, v + 1); ++j)
      for (int i = std::max(0, u - 1); i <= std::min(depth_->width() - 1, u + 1); ++i) {
        const float d = (*depth_)(i, j);
        if (d > 0 && (usable_ == nullptr || (*usable_)(i, j) != 0) && (least == 0 || d < least)) least = d;
      }
    return landing.depth < least * (1 - tolerance);
  }

 private:
  WarpMap map_;
  const DepthMap* depth_;
  const ValidityMask* usable_;
};

/// The nearest thing found so far for a pixel.
struct Candidate {
  float depth = 0;  ///< 0 = none.
  bool shows = false;
  Rgb8 colour{};
};

std::uint8_t brightened(std::uint8_t value, float gain) {
  return static_cast<std::uint8_t>(std::clamp(static_cast<float>(value) * gain + 0.5F, 0.0F, 255.0F));
}

/// A z-buffer that is full where `valid` is 1: only open pixels can be drawn into.
void occupy(const ValidityMask& valid, ZBuffer& zbuffer) {
  zbuffer.winner.resize(valid.size());
  zbuffer.depth.resize(valid.size());
  zbuffer.depth.fill(0);
  zbuffer.reach.clear();
  std::transform(valid.pixels().begin(), valid.pixels().end(), zbuffer.winner.pixels().begin(),
                 [](std::uint8_t known) { return known != 0 ? 0U : PointCode::none; });
}

/// Takes out what occupy() put in.
void vacate(const ValidityMask& valid, ZBuffer& zbuffer) {
  for (std::size_t i = 0; i < valid.pixels().size(); ++i)
    if (valid.pixels()[i] != 0) zbuffer.winner.pixels()[i] = PointCode::none;
}

}  // namespace

struct OtherViews::State {
  Rasterizer& rasterizer;
  ThreadPool& pool;
  const OcclusionOptions occlusion;
  const OtherViewsOptions options;
  std::vector<PreparedView> views;

  std::optional<long> own_index;
  SlopeMap own_slopes;
  ZBuffer zbuffer;
  RenderedFrame drawn;
  ValidityMask front;
  Image<Candidate> candidates;

  void draw(const PointGrid& points, const ImageRgb& colour, const Camera& target, const ValidityMask& valid) {
    occupy(valid, zbuffer);
    rasterizer.fill(points, target, occlusion.footprint, zbuffer);
    vacate(valid, zbuffer);
    if (occlusion.kernel == Kernel::nearest)
      detail::nearest_colour(zbuffer, colour, pool, drawn);
    else
      detail::resampled_colour(points, target, zbuffer, colour, pool, drawn);
    if (occlusion.normal_filter) front_mask(points, target, std::cos(occlusion.alpha), pool, front);
  }

  /// Calls each(x, y) for every open pixel.
  template <class Each>
  void for_open(const ValidityMask& valid, const Each& each) {
    pool.for_ranges(0, valid.height(), 16, [&](int from, int to) {
      for (int y = from; y < to; ++y)
        for (int x = 0; x < valid.width(); ++x)
          if (valid(x, y) == 0) each(x, y);
    });
  }

  std::vector<std::size_t> choose(long own, const Camera& target, const RenderedFrame& frame,
                                  std::vector<detail::ViewSurvey>& surveys, FillReport& report);
  void offer(const PreparedView& view, const std::array<float, 3>& gain, const std::vector<SeesThrough>& witnesses,
             const Camera& target, const ValidityMask& valid, FillReport& report);
  void find_own_occluders(const SourceFrame& own, const Camera& target, const ValidityMask& valid);
  void take(RenderedFrame& frame, FillReport& report);
};

std::vector<std::size_t> OtherViews::State::choose(long own, const Camera& target, const RenderedFrame& frame,
                                                   std::vector<detail::ViewSurvey>& surveys, FillReport& report) {
  const detail::OpenCells cells(frame.valid);
  report.open = cells.total;
  const auto least = static_cast<std::size_t>(options.min_gain * static_cast<double>(target.size.pixels()));
  surveys.assign(views.size(), {});
  if (cells.total == 0 || cells.total < least) return {};
  pool.run(static_cast<int>(views.size()), [&](int i) {
    const OtherView& view = views[static_cast<std::size_t>(i)].view;
    if (view.index != own)
      surveys[static_cast<std::size_t>(i)] = detail::survey_view(view, target, frame, cells, options);
  });
  for (detail::ViewSurvey& survey : surveys)
    if (survey.contradiction() > options.max_contradiction) {
      ++report.refused;
      survey.reaches.clear();
    }
  return detail::choose_views(surveys, cells, least, options);
}

/// Draws a view into the open pixels and keeps for each what is nearest.
void OtherViews::State::offer(const PreparedView& view, const std::array<float, 3>& gain,
                              const std::vector<SeesThrough>& witnesses, const Camera& target,
                              const ValidityMask& valid, FillReport& report) {
  draw(view.grid(), view.view.colour, target, valid);
  std::atomic<std::size_t> contradicted{0};
  for_open(valid, [&](int x, int y) {
    const std::uint32_t code = zbuffer.winner(x, y);
    if (code == PointCode::none) return;
    const float z = drawn.depth(x, y);
    Candidate& best = candidates(x, y);
    const bool shows = !occlusion.normal_filter || front(PointCode::x(code), PointCode::y(code)) != 0;
    const bool nearer = best.depth == 0 || z < best.depth * (1 - options.tolerance);
    const bool same = !nearer && z <= best.depth * (1 + options.tolerance);
    if (!nearer && !(same && shows && !best.shows)) return;
    for (const SeesThrough& sees_through : witnesses)
      if (sees_through(x, y, z, options.tolerance)) {
        ++contradicted;
        return;
      }
    const Rgb8& c = drawn.colour(x, y);
    best = {z, shows, {brightened(c.r, gain[0]), brightened(c.g, gain[1]), brightened(c.b, gain[2])}};
  });
  report.contradicted += contradicted;
}

/// The frame's own points at open pixels, whatever kept them from being drawn, into `zbuffer`.
void OtherViews::State::find_own_occluders(const SourceFrame& own, const Camera& target, const ValidityMask& valid) {
  if (own.slopes == nullptr && own_index != own.index) {
    limited_slopes_from_depth(*own.depth, own.camera.intrinsics, occlusion.slopes, pool, own_slopes);
    own_index = own.index;
  }
  occupy(valid, zbuffer);
  rasterizer.fill({own.camera, own.depth, own.slopes != nullptr ? own.slopes : &own_slopes, own.valid}, target,
                  occlusion.footprint, zbuffer);
}

void OtherViews::State::take(RenderedFrame& frame, FillReport& report) {
  std::atomic<std::size_t> filled{0}, hidden{0};
  const ValidityMask was_valid = frame.valid;
  for_open(was_valid, [&](int x, int y) {
    const Candidate& best = candidates(x, y);
    if (best.depth == 0) return;
    const float own = zbuffer.winner(x, y) != PointCode::none ? zbuffer.depth(x, y) : 0.0F;
    if (!best.shows || (own > 0 && own < best.depth * (1 - options.tolerance))) {
      ++hidden;
      return;
    }
    frame.colour(x, y) = best.colour;
    frame.depth(x, y) = best.depth;
    frame.valid(x, y) = 1;
    ++filled;
  });
  report.filled = filled;
  report.hidden = hidden;
}

OtherViews::OtherViews(Rasterizer& rasterizer, ThreadPool& pool, const OcclusionOptions& occlusion,
                       const OtherViewsOptions& options)
    : state_(new State{rasterizer, pool, occlusion, options, {}, {}, {}, {}, {}, {}, {}}) {
  occlusion.check();
  options.check();
}

OtherViews::~OtherViews() = default;

void OtherViews::add(OtherView view) {
  const Size size = view.camera.size;
  require(view.colour.size() == size && view.depth.size() == size && view.usable.size() == size,
          "view {}: colour, depth and mask do not all have its camera's size {}x{}", view.index, size.width,
          size.height);
  intersect(view.usable, reliable_depth(view.depth, away_from_edges, state_->pool));
  PreparedView prepared{std::move(view), {}};
  limited_slopes_from_depth(prepared.view.depth, prepared.view.camera.intrinsics, state_->occlusion.slopes,
                            state_->pool, prepared.slopes);
  prepared.grid().check();
  state_->views.push_back(std::move(prepared));
}

std::size_t OtherViews::size() const { return state_->views.size(); }

FillReport OtherViews::fill(const SourceFrame& own, const Camera& target, RenderedFrame& frame) {
  const auto start = std::chrono::steady_clock::now();
  require(own.depth != nullptr, "the frame's own depth is missing");
  require(frame.valid.size() == target.size && frame.depth.size() == target.size && frame.colour.size() == target.size,
          "the rendered frame is {}x{}, its camera {}x{}", frame.valid.width(), frame.valid.height(), target.size.width,
          target.size.height);
  State& state = *state_;
  FillReport report;
  std::vector<detail::ViewSurvey> surveys;
  const std::vector<std::size_t> chosen = state.choose(own.index, target, frame, surveys, report);
  report.views = static_cast<int>(chosen.size());
  if (!chosen.empty()) {
    std::vector<SeesThrough> witnesses{{own.camera, target, *own.depth, own.valid}};
    for (const std::size_t i : chosen) {
      const OtherView& view = state.views[i].view;
      witnesses.emplace_back(view.camera, target, view.depth, &view.usable);
    }
    state.candidates = Image<Candidate>(target.size);
    for (const std::size_t i : chosen)
      state.offer(state.views[i], surveys[i].gain, witnesses, target, frame.valid, report);
    state.find_own_occluders(own, target, frame.valid);
    state.take(frame, report);
  }
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

void OtherViewsOptions::check() const {
  require(max_views >= 1 && max_views <= 64, "max_views {} is outside 1..64", max_views);
  require(min_gain >= 0 && min_gain <= 1, "min_gain {} is outside 0..1", min_gain);
  require(tolerance >= 0 && tolerance <= 0.5F, "tolerance {} is outside 0..0.5", tolerance);
  require(max_contradiction >= 0 && max_contradiction <= 1, "max_contradiction {} is outside 0..1", max_contradiction);
  require(max_gain >= 1 && max_gain <= 4, "max_gain {} is outside 1..4", max_gain);
}

}  // namespace uwv
