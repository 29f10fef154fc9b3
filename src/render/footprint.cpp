// SPDX-License-Identifier: Apache-2.0
#include "render/footprint.h"

#include <cmath>

#include "uwv/core/simd.h"

namespace uwv::detail {
namespace {

constexpr Slope facing_camera[block_size] = {};

constexpr std::array<std::uint8_t, block_size> all_kept = [] {
  std::array<std::uint8_t, block_size> ones{};
  ones.fill(1);
  return ones;
}();

}  // namespace

UWV_SIMD_CLONES void footprints_of_block(const WarpMap& map, int x, int y, int count, const float* depth,
                                         const Slope* slopes, const std::uint8_t* keep, const FootprintLimits& limits,
                                         Footprints& out) {
  const float fy = static_cast<float>(y);
  const float row0 = map.a[0][1] * fy + map.a[0][2];
  const float row1 = map.a[1][1] * fy + map.a[1][2];
  const float row2 = map.a[2][1] * fy + map.a[2][2];
  const float a00 = map.a[0][0], a10 = map.a[1][0], a20 = map.a[2][0];
  const float a01 = map.a[0][1], a11 = map.a[1][1], a21 = map.a[2][1];
  const float b0 = map.b[0], b1 = map.b[1], b2 = map.b[2];
  const float half_size = 0.5F * limits.point_size;
  const float max_half = limits.max_half;
  const float last_x = limits.width - 1.0F, last_y = limits.height - 1.0F;
  const float* z_of = depth;
  const Slope* slope_of = slopes != nullptr ? slopes : facing_camera;
  const std::uint8_t* kept = keep != nullptr ? keep : all_kept.data();
  std::int32_t* out_x0 = out.x0.data();
  std::int32_t* out_x1 = out.x1.data();
  std::int32_t* out_y0 = out.y0.data();
  std::int32_t* out_y1 = out.y1.data();
  float* out_depth = out.depth.data();
#pragma GCC ivdep  // inputs and outputs never overlap
  for (int i = 0; i < count; ++i) {
    const float z = z_of[i];
    const float sx = slope_of[i].x, sy = slope_of[i].y;
    const float fx = static_cast<float>(x + i);
    const float p0 = z * (a00 * fx + row0) + b0;
    const float p1 = z * (a10 * fx + row1) + b1;
    const float p2 = z * (a20 * fx + row2) + b2;
    const float inverse = 1.0F / p2;
    const float u = p0 / p2;
    const float v = p1 / p2;
    const float wx = z * a20 + b2 * sx;
    const float wy = z * a21 + b2 * sy;
    const float j00 = ((z * a00 + b0 * sx) - u * wx) * inverse;
    const float j01 = ((z * a01 + b0 * sy) - u * wy) * inverse;
    const float j10 = ((z * a10 + b1 * sx) - v * wx) * inverse;
    const float j11 = ((z * a11 + b1 * sy) - v * wy) * inverse;
    float hx = half_size * (std::fabs(j00) + std::fabs(j01));
    float hy = half_size * (std::fabs(j10) + std::fabs(j11));
    const bool has_size = (hx == hx) & (hy == hy);  // no NaN
    hx = hx > 0.5F ? hx : 0.5F;
    hy = hy > 0.5F ? hy : 0.5F;
    hx = hx < max_half ? hx : max_half;
    hy = hy < max_half ? hy : max_half;
    float x0 = std::ceil(u - (hx + 0.5F));
    float x1 = std::ceil(u + (hx - 0.5F)) - 1.0F;
    float y0 = std::ceil(v - (hy + 0.5F));
    float y1 = std::ceil(v + (hy - 0.5F)) - 1.0F;
    x0 = x0 > 0.0F ? x0 : 0.0F;
    y0 = y0 > 0.0F ? y0 : 0.0F;
    x1 = x1 < last_x ? x1 : last_x;
    y1 = y1 < last_y ? y1 : last_y;
    // x0 < width and x1 >= 0 follow from x0 <= x1 but for NaN and for rectangles outside, which every comparison
    // refuses.
    const bool draws = (kept[i] != 0) & has_size & (z > 0.0F) & (p2 > 0.0F) & (p2 <= max_depth) & (x0 <= x1) &
                       (y0 <= y1) & (x0 <= last_x) & (x1 >= 0.0F) & (y0 <= last_y) & (y1 >= 0.0F) &
                       (std::fabs(u) <= 1e9F) & (std::fabs(v) <= 1e9F);
    out_x0[i] = draws ? static_cast<std::int32_t>(x0) : 0;
    out_x1[i] = draws ? static_cast<std::int32_t>(x1) : -1;
    out_y0[i] = draws ? static_cast<std::int32_t>(y0) : 0;
    out_y1[i] = draws ? static_cast<std::int32_t>(y1) : -1;
    out_depth[i] = p2;
  }
}

}  // namespace uwv::detail
