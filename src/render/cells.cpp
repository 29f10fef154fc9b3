// SPDX-License-Identifier: Apache-2.0
#include "render/cells.h"

#include <algorithm>
#include <cmath>

namespace uwv::detail {
namespace {

constexpr std::int32_t nowhere = 65536;  // as footprints_of_block has it

bool any_of_square(const ValidityMask& mask, int x0, int y0, int side) {
  const int x1 = std::min(x0 + side, mask.width()), y1 = std::min(y0 + side, mask.height());
  for (int y = y0; y < y1; ++y)
    if (std::any_of(mask.row(y) + x0, mask.row(y) + x1, [](std::uint8_t bit) { return bit != 0; })) return true;
  return false;
}

struct Span {
  std::int32_t first, last;
};

/// The pixels of a row or column whose centres lie in [centre - half, centre + half).
Span covered(float centre, float half, float last) {
  const float first = std::max(std::ceil(centre - (half + 0.5F)), 0.0F);
  const float end = std::min(std::ceil(centre + (half - 0.5F)) - 1.0F, last);
  return {static_cast<std::int32_t>(std::min(first, static_cast<float>(nowhere))),
          static_cast<std::int32_t>(std::max(end, -1.0F))};
}

}  // namespace

void footprints_of_cells(const WarpMap& map, int x, int y, int count, const BlockOfPoints& points,
                         const FootprintLimits& limits, Footprints& out) {
  out.x0.fill(nowhere), out.y0.fill(nowhere);
  out.x1.fill(-1), out.y1.fill(-1);
  for (int i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    out.depth[at] = 0;
    if ((points.keep != nullptr && points.keep[i] == 0) || !(points.depth[i] > 0)) continue;
    const auto side = static_cast<float>(std::max<std::uint8_t>(points.cells[i], 1));
    const Slope slope = points.slopes != nullptr ? points.slopes[i] : Slope{};
    const float shift = side > 1 ? 0.5F : 0.0F;
    const float shrink = 1.0F - shift * (slope.x + slope.y);  // 1/z at the cell's centre over 1/z at the point
    if (!(shrink > 0)) continue;
    const float z = points.depth[i] / shrink, sx = slope.x / shrink, sy = slope.y / shrink;
    const float px = static_cast<float>(x + i) - shift, py = static_cast<float>(y) - shift;
    const auto row = [&](std::size_t k) {
      return z * (map.a[k][0] * px + (map.a[k][1] * py + map.a[k][2])) + map.b[k];
    };
    const float p2 = row(2);
    if (!(p2 > 0) || !(p2 <= max_depth)) continue;
    const float inverse = 1.0F / p2, u = row(0) / p2, v = row(1) / p2;
    if (!(std::fabs(u) <= 1e9F) || !(std::fabs(v) <= 1e9F)) continue;
    const float wx = z * map.a[2][0] + map.b[2] * sx, wy = z * map.a[2][1] + map.b[2] * sy;
    const float j00 = ((z * map.a[0][0] + map.b[0] * sx) - u * wx) * inverse;
    const float j01 = ((z * map.a[0][1] + map.b[0] * sy) - u * wy) * inverse;
    const float j10 = ((z * map.a[1][0] + map.b[1] * sx) - v * wx) * inverse;
    const float j11 = ((z * map.a[1][1] + map.b[1] * sy) - v * wy) * inverse;
    const float half = 0.5F * limits.point_size * (side > 1 ? side + 1 : side);
    const float hx = std::clamp(half * (std::fabs(j00) + std::fabs(j01)), limits.min_half, limits.max_half * side);
    const float hy = std::clamp(half * (std::fabs(j10) + std::fabs(j11)), limits.min_half, limits.max_half * side);
    if (hx != hx || hy != hy) continue;
    const Span across = covered(u, hx, limits.width - 1), down = covered(v, hy, limits.height - 1);
    if (across.first > across.last || down.first > down.last) continue;
    out.x0[at] = across.first, out.x1[at] = across.last;
    out.y0[at] = down.first, out.y1[at] = down.last;
    out.depth[at] = p2;
  }
}

CellPlane::CellPlane(const WarpMap& map, int x, int y, float depth, const Slope& slope, int side) : map_(map) {
  const float xs = static_cast<float>(x) + 0.5F, ys = static_cast<float>(y) + 0.5F;
  const std::array<float, 3> m{slope.x, slope.y, 1 - slope.x * xs - slope.y * ys};
  for (std::size_t i = 0; i < 3; ++i)
    n_[i] = map.a_inverse[0][i] * m[0] + map.a_inverse[1][i] * m[1] + map.a_inverse[2][i] * m[2];
  lift_ = depth + (m[0] * map.k[0] + m[1] * map.k[1] + m[2] * map.k[2]);
  // Neighbouring cells have planes of their own: without some overlap, cracks would open between them.
  constexpr float overlap = 0.5F;
  const int across = std::max(side, 1);
  x0_ = static_cast<float>(x - x % across) - overlap, x1_ = x0_ + static_cast<float>(across) + 2 * overlap;
  y0_ = static_cast<float>(y - y % across) - overlap, y1_ = y0_ + static_cast<float>(across) + 2 * overlap;
}

void spread_over_cells(const Image<std::uint8_t>& cells, const ValidityMask& kept, ThreadPool& pool,
                       ValidityMask& seen) {
  ValidityMask spread = seen;
  pool.for_ranges(0, cells.height(), 16, [&](int from, int to) {
    for (int y = from; y < to; ++y)
      for (int x = 0; x < cells.width(); ++x)
        if (const int side = cells(x, y); side > 1 && kept(x, y) != 0 && seen(x, y) == 0)
          spread(x, y) = static_cast<std::uint8_t>(any_of_square(seen, x - x % side, y - y % side, side));
  });
  seen = std::move(spread);
}

}  // namespace uwv::detail
