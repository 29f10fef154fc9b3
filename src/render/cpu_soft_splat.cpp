// SPDX-License-Identifier: Apache-2.0
#include "render/cpu_soft_splat.h"

#include <Eigen/Core>

#include <algorithm>
#include <bit>
#include <cmath>
#include <mutex>

#include "uwv/core/simd.h"

namespace uwv::detail {
namespace {

/// Depths enter the weights clamped to this, as in the reference.
constexpr float farthest_weighed = 1000.0F;

float log_depth(float z) { return std::log1p(std::fmin(std::fmax(z, 0.0F), farthest_weighed)); }

/// One row of SoftPoints.
struct SoftRow {
  float *x, *y, *depth, *weight;
};

/// Extremes over a row, as bit patterns: those of numbers >= 0 order like the numbers, and unlike float minima the
/// compiler may take them in SIMD lanes.
struct RowExtremes {
  std::int32_t farthest = 0;
  std::int32_t top = 0x7F800000, bottom = 0;  // +inf, 0
};

/// Lands a row. Weights become 1 for points that draw. The farthest depth counts dropped points too, as the reference
/// does.
UWV_SIMD_CLONES RowExtremes land_row(const WarpMap& map, int y, int width, const float* depth, Size target,
                                     const SoftRow& out) {
  const float fy = static_cast<float>(y);
  const float row0 = map.a[0][1] * fy + map.a[0][2];
  const float row1 = map.a[1][1] * fy + map.a[1][2];
  const float row2 = map.a[2][1] * fy + map.a[2][2];
  const float a00 = map.a[0][0], a10 = map.a[1][0], a20 = map.a[2][0];
  const float b0 = map.b[0], b1 = map.b[1], b2 = map.b[2];
  const float right = static_cast<float>(target.width + 1), bottom = static_cast<float>(target.height + 1);
  float* out_x = out.x;
  float* out_y = out.y;
  float* out_depth = out.depth;
  float* out_weight = out.weight;
  std::int32_t farthest = 0, first = RowExtremes{}.top, last = 0;
#pragma GCC ivdep  // inputs and outputs never overlap
  for (int x = 0; x < width; ++x) {
    const float z = depth[x];
    const float fx = static_cast<float>(x);
    const float p2 = z * (a20 * fx + row2) + b2;
    const float u = (z * (a00 * fx + row0) + b0) / p2;
    const float v = (z * (a10 * fx + row1) + b1) / p2;
    const bool in_front = (z > 0.0F) & (p2 > 0.0F);
    const bool draws = in_front & (p2 <= max_depth) & (std::fabs(u) < 1e30F) & (std::fabs(v) < 1e30F);
    // Half a pixel back to integer centres, one pixel of padding forward.
    float cx = u + 0.5F > 0.0F ? u + 0.5F : 0.0F, cy = v + 0.5F > 0.0F ? v + 0.5F : 0.0F;
    cx = cx < right ? cx : right;
    cy = cy < bottom ? cy : bottom;
    out_x[x] = draws ? cx : 0.0F;
    out_y[x] = draws ? cy : 0.0F;
    out_depth[x] = draws ? p2 : 0.0F;
    out_weight[x] = draws ? 1.0F : 0.0F;
    const std::int32_t depth_bits = in_front ? std::bit_cast<std::int32_t>(p2) : 0;
    const std::int32_t y_bits = std::bit_cast<std::int32_t>(cy);
    farthest = depth_bits > farthest ? depth_bits : farthest;
    first = draws & (y_bits < first) ? y_bits : first;
    last = draws & (y_bits > last) ? y_bits : last;
  }
  return {farthest, first, last};
}

/// First pass: where every point lands. Returns L_max over all of them.
float land_all(const PointGrid& points, const WarpMap& map, Size target, ThreadPool& pool, SoftPoints& out) {
  const Size size = points.camera.size;
  out.resize(size);
  std::mutex mutex;
  std::int32_t farthest = 0;
  pool.for_ranges(0, size.height, 8, [&](int from, int to) {
    std::int32_t far_here = 0;
    for (int y = from; y < to; ++y) {
      const SoftRow row{out.x.row(y), out.y.row(y), out.depth.row(y), out.weight.row(y)};
      const RowExtremes extremes = land_row(map, y, size.width, points.depth->row(y), target, row);
      far_here = std::max(far_here, extremes.farthest);
      out.top[static_cast<std::size_t>(y)] = std::bit_cast<float>(extremes.top);
      out.bottom[static_cast<std::size_t>(y)] = std::bit_cast<float>(extremes.bottom);
    }
    const std::lock_guard lock(mutex);
    farthest = std::max(farthest, far_here);
  });
  return log_depth(std::bit_cast<float>(farthest));
}

/// Second pass: exp(-sharpness * L / L_max) for every point that draws. Eigen's packet functions, always compiled for
/// the same instruction set, give the same bits on every processor.
void weigh_all(const PointGrid& grid, float sharpness, float log_depth_max, ThreadPool& pool, SoftPoints& points) {
  const float rate = log_depth_max > 0 ? sharpness / log_depth_max : 0.0F;
  const int width = points.x.width();
  pool.for_ranges(0, points.x.height(), 8, [&](int from, int to) {
    for (int y = from; y < to; ++y) {
      const Eigen::Map<const Eigen::ArrayXf> depth(points.depth.row(y), width);
      Eigen::Map<Eigen::ArrayXf> weight(points.weight.row(y), width);
      if (grid.keep != nullptr)
        weight *=
            Eigen::Map<const Eigen::Array<std::uint8_t, Eigen::Dynamic, 1>>(grid.keep->row(y), width).cast<float>();
      weight *= (-rate * depth.min(farthest_weighed).log1p()).exp();
    }
  });
}

ColourSum::Value value_of(const ColourSum&, const RgbF* colour, float depth) {
  return ColourSum::Value{colour->r, colour->g, colour->b, depth};
}
DepthSum::Value value_of(const DepthSum&, const RgbF*, float depth) { return depth; }

template <class Sum>
void add(Sum& sum, float weight, const typename Sum::Value& value) {
  sum.value += weight * value;
  sum.weight += weight;
}

/// Canvas rows one thread owns; what lands outside is another thread's, or padding that nobody keeps.
template <class Sum>
struct Band {
  Sum* sums;
  std::size_t stride;
  int first, last;

  Sum* row(int y) const { return y >= first && y <= last ? sums + static_cast<std::size_t>(y) * stride : nullptr; }

  void add_point(float x, float y, float weight, const typename Sum::Value& value) const {
    const int left = static_cast<int>(x), top = static_cast<int>(y);
    const float fx = x - static_cast<float>(left), fy = y - static_cast<float>(top);
    // The reference takes floor and ceil: a point on a pixel's centre counts fully for both, which are the same.
    const int right = left + (fx > 0 ? 1 : 0), bottom = top + (fy > 0 ? 1 : 0);
    const float wl = 1.0F - fx, wr = 1.0F - (static_cast<float>(right) - x);
    const float wt = 1.0F - fy, wb = 1.0F - (static_cast<float>(bottom) - y);
    Sum* above = row(top);
    Sum* below = row(bottom);
    if (above != nullptr) add(above[left], wt * wl * weight, value);
    if (below != nullptr) add(below[left], wb * wl * weight, value);
    if (above != nullptr) add(above[right], wt * wr * weight, value);
    if (below != nullptr) add(below[right], wb * wr * weight, value);
  }
};

/// Third pass. Each thread owns a band of canvas rows and adds every point in source order, so that sums do not depend
/// on the number of threads.
template <class Sum>
void accumulate(const SoftPoints& points, const ImageRgbF* colour, Size target, ThreadPool& pool,
                std::vector<Sum, CacheAligned<Sum>>& sums) {
  const std::size_t stride = static_cast<std::size_t>(target.width) + 2;
  sums.resize(stride * (static_cast<std::size_t>(target.height) + 2));
  const int bands = std::min(pool.size(), target.height);
  pool.run(bands, [&](int part) {
    const auto edge = [&](int p) { return 1 + static_cast<int>(static_cast<long>(target.height) * p / bands); };
    const Band<Sum> band{sums.data(), stride, edge(part), edge(part + 1) - 1};
    std::fill(sums.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(band.first) * stride),
              sums.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(band.last + 1) * stride), Sum{});
    const float above = static_cast<float>(band.first - 1), below = static_cast<float>(band.last + 1);
    for (int y = 0; y < points.x.height(); ++y) {
      const auto at = static_cast<std::size_t>(y);
      if (points.bottom[at] <= above || points.top[at] >= below) continue;
      const RgbF* colours = colour != nullptr ? colour->row(y) : nullptr;
      const float *px = points.x.row(y), *py = points.y.row(y), *pz = points.depth.row(y), *pw = points.weight.row(y);
      for (int x = 0; x < points.x.width(); ++x) {
        if (!(pw[x] > 0) || py[x] <= above || py[x] >= below) continue;
        band.add_point(px[x], py[x], pw[x], value_of(Sum{}, colours != nullptr ? colours + x : nullptr, pz[x]));
      }
    }
  });
}

/// Calls emit(x, y, sum or null) for every target pixel.
template <class Sum, class Emit>
void for_sums(const std::vector<Sum, CacheAligned<Sum>>& sums, Size target, ThreadPool& pool, const Emit& emit) {
  pool.for_ranges(0, target.height, 16, [&](int from, int to) {
    for (int y = from; y < to; ++y) {
      const Sum* row =
          sums.data() + (static_cast<std::size_t>(y) + 1) * (static_cast<std::size_t>(target.width) + 2) + 1;
      for (int x = 0; x < target.width; ++x) emit(x, y, row[x].weight > 0 ? &row[x] : nullptr);
    }
  });
}

void splat_colour(const SoftPoints& points, const ImageRgbF& colour, Size target, ThreadPool& pool,
                  SoftScratch& scratch, SoftSplat& out) {
  accumulate(points, &colour, target, pool, scratch.colour_sums);
  out.colour.resize(target);
  for_sums(scratch.colour_sums, target, pool, [&](int x, int y, const ColourSum* sum) {
    const ColourSum::Value mean = sum != nullptr ? sum->value / sum->weight : ColourSum::Value{};
    out.colour(x, y) = {mean[0], mean[1], mean[2]};
    out.depth(x, y) = mean[3];
    out.valid(x, y) = static_cast<std::uint8_t>(sum != nullptr);
  });
}

void splat_depth(const SoftPoints& points, Size target, ThreadPool& pool, SoftScratch& scratch, SoftSplat& out) {
  accumulate(points, nullptr, target, pool, scratch.depth_sums);
  out.colour.resize({});
  for_sums(scratch.depth_sums, target, pool, [&](int x, int y, const DepthSum* sum) {
    out.depth(x, y) = sum != nullptr ? sum->value / sum->weight : 0.0F;
    out.valid(x, y) = static_cast<std::uint8_t>(sum != nullptr);
  });
}

}  // namespace

void SoftPoints::resize(Size size) {
  for (Image<float>* plane : {&x, &y, &depth, &weight}) plane->resize(size);
  top.resize(static_cast<std::size_t>(size.height));
  bottom.resize(static_cast<std::size_t>(size.height));
}

void soft_splat(const PointGrid& points, const ImageRgbF* colour, const Camera& target, const SoftSplatOptions& options,
                ThreadPool& pool, SoftScratch& scratch, SoftSplat& out) {
  require(colour == nullptr || colour->size() == points.camera.size, "the colours do not have the grid's size");
  const WarpMap map = WarpMap::between(points.camera, target);
  const float own_max = land_all(points, map, target.size, pool, scratch.points);
  weigh_all(points, options.sharpness, options.log_depth_max > 0 ? options.log_depth_max : own_max, pool,
            scratch.points);
  out.depth.resize(target.size);
  out.valid.resize(target.size);
  if (colour != nullptr)
    splat_colour(scratch.points, *colour, target.size, pool, scratch, out);
  else
    splat_depth(scratch.points, target.size, pool, scratch, out);
}

}  // namespace uwv::detail
