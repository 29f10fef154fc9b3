// SPDX-License-Identifier: Apache-2.0
#include "render/cpu_soft_splat.h"

#include <cmath>
#include <mutex>

namespace uwv::detail {
namespace {

/// The reference's L = ln(1 + clamp(z, 0, 1000)).
float log_depth(float z) { return std::log1p(std::fmin(std::fmax(z, 0.0F), 1000.0F)); }

/// First pass: where every point lands, and L_max over all of them, dropped ones included as in the reference.
float project_all(const PointGrid& points, const WarpMap& map, Size target, ThreadPool& pool, Image<SoftPoint>& out) {
  const Size size = points.camera.size;
  out.resize(size);
  const float right = static_cast<float>(target.width + 1), bottom = static_cast<float>(target.height + 1);
  std::mutex mutex;
  float farthest = 0.0F;
  pool.for_ranges(0, size.height, 8, [&](int from, int to) {
    float far_here = 0.0F;
    for (int y = from; y < to; ++y) {
      for (int x = 0; x < size.width; ++x) {
        SoftPoint& point = out(x, y);
        point.weight = 0.0F;
        const float z = (*points.depth)(x, y);
        if (!(z > 0)) continue;
        const WarpMap::Landing p = map.apply(x, y, z);
        far_here = std::fmax(far_here, p.depth);
        const bool kept = points.keep == nullptr || (*points.keep)(x, y) != 0;
        if (!kept || !(p.depth > 0 && p.depth <= max_depth) || !std::isfinite(p.u) || !std::isfinite(p.v)) continue;
        // Half a pixel back to integer centres, one pixel of padding forward.
        point = {std::fmin(std::fmax(p.u + 0.5F, 0.0F), right), std::fmin(std::fmax(p.v + 0.5F, 0.0F), bottom), p.depth,
                 1.0F};
      }
    }
    const std::lock_guard lock(mutex);
    farthest = std::fmax(farthest, far_here);
  });
  return log_depth(farthest);
}

/// exp(-sharpness * L / L_max) for every point that draws.
void weigh(Image<SoftPoint>& points, float sharpness, float log_depth_max, ThreadPool& pool) {
  const float rate = log_depth_max > 0 ? sharpness / log_depth_max : 0.0F;
  pool.for_ranges(0, points.height(), 8, [&](int from, int to) {
    for (int y = from; y < to; ++y)
      for (int x = 0; x < points.width(); ++x) {
        SoftPoint& point = points(x, y);
        if (point.weight > 0) point.weight = std::exp(-rate * log_depth(point.depth));
      }
  });
}

struct Splatter {
  Image<SoftSum>& sums;
  int first_row, last_row;  ///< Target rows this thread owns.

  /// Adds to a pixel of the padded canvas; the padding itself is thrown away.
  void add(int px, int py, float weight, const RgbF& colour, float depth) const {
    const int x = px - 1, y = py - 1;
    if (x < 0 || x >= sums.width() || y < first_row || y > last_row) return;
    SoftSum& sum = sums(x, y);
    sum.r += weight * colour.r;
    sum.g += weight * colour.g;
    sum.b += weight * colour.b;
    sum.depth += weight * depth;
    sum.weight += weight;
  }

  void add_point(const SoftPoint& p, const RgbF& colour) const {
    const float x0 = std::floor(p.x), x1 = std::ceil(p.x), y0 = std::floor(p.y), y1 = std::ceil(p.y);
    const int left = static_cast<int>(x0), right = static_cast<int>(x1);
    const int top = static_cast<int>(y0), bottom = static_cast<int>(y1);
    const float wl = 1.0F - (p.x - x0), wr = 1.0F - (x1 - p.x), wt = 1.0F - (p.y - y0), wb = 1.0F - (y1 - p.y);
    add(left, top, wt * wl * p.weight, colour, p.depth);
    add(left, bottom, wb * wl * p.weight, colour, p.depth);
    add(right, top, wt * wr * p.weight, colour, p.depth);
    add(right, bottom, wb * wr * p.weight, colour, p.depth);
  }
};

/// Each thread owns a band of target rows and adds every point in source order, so that sums do not depend on the
/// number of threads.
void accumulate(const Image<SoftPoint>& points, const ImageRgbF* colour, Size target, ThreadPool& pool,
                Image<SoftSum>& sums) {
  const int bands = std::min(pool.size(), target.height);
  pool.run(bands, [&](int band) {
    const int first = static_cast<int>(static_cast<long>(target.height) * band / bands);
    const int last = static_cast<int>(static_cast<long>(target.height) * (band + 1) / bands) - 1;
    for (int y = first; y <= last; ++y) std::fill_n(sums.row(y), target.width, SoftSum{});
    const Splatter splatter{sums, first, last};
    // Padded row of target row r is r + 1; a point reaches the rows on both sides of its y.
    const float above = static_cast<float>(first), below = static_cast<float>(last + 2);
    for (int y = 0; y < points.height(); ++y) {
      const SoftPoint* row = points.row(y);
      const RgbF* colours = colour != nullptr ? colour->row(y) : nullptr;
      for (int x = 0; x < points.width(); ++x) {
        if (!(row[x].weight > 0) || row[x].y <= above || row[x].y >= below) continue;
        splatter.add_point(row[x], colours != nullptr ? colours[x] : RgbF{});
      }
    }
  });
}

void normalise(const Image<SoftSum>& sums, bool with_colour, ThreadPool& pool, SoftSplat& out) {
  out.colour.resize(with_colour ? sums.size() : Size{});
  out.depth.resize(sums.size());
  out.valid.resize(sums.size());
  pool.for_ranges(0, sums.height(), 16, [&](int from, int to) {
    for (int y = from; y < to; ++y)
      for (int x = 0; x < sums.width(); ++x) {
        const SoftSum& sum = sums(x, y);
        const bool hit = sum.weight > 0;
        const float divisor = hit ? sum.weight : 1.0F;
        if (with_colour) out.colour(x, y) = hit ? RgbF{sum.r / divisor, sum.g / divisor, sum.b / divisor} : RgbF{};
        out.depth(x, y) = hit ? sum.depth / divisor : 0.0F;
        out.valid(x, y) = hit;
      }
  });
}

}  // namespace

void soft_splat(const PointGrid& points, const ImageRgbF* colour, const Camera& target, const SoftSplatOptions& options,
                ThreadPool& pool, SoftScratch& scratch, SoftSplat& out) {
  require(colour == nullptr || colour->size() == points.camera.size, "the colours do not have the grid's size");
  const WarpMap map = WarpMap::between(points.camera, target);
  const float own_max = project_all(points, map, target.size, pool, scratch.points);
  weigh(scratch.points, options.sharpness, options.log_depth_max > 0 ? options.log_depth_max : own_max, pool);
  scratch.sums.resize(target.size);
  accumulate(scratch.points, colour, target.size, pool, scratch.sums);
  normalise(scratch.sums, colour != nullptr, pool, out);
}

}  // namespace uwv::detail
