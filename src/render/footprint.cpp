// SPDX-License-Identifier: Apache-2.0
#include "render/footprint.h"

#include <cmath>

#include "uwv/core/simd.h"

namespace uwv::detail {
namespace {

constexpr Slope facing_camera[block_size] = {};

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
  const Slope* tilt = slopes != nullptr ? slopes : facing_camera;
  for (int i = 0; i < count; ++i) {
    const float z = depth[i];
    const float sx = tilt[i].x, sy = tilt[i].y;
    const float fx = static_cast<float>(x + i);
    const float p0 = z * (a00 * fx + row0) + b0;
    const float p1 = z * (a10 * fx + row1) + b1;
    const float p2 = z * (a20 * fx + row2) + b2;
    const float inverse = 1.0F / p2;
    const float u = p0 * inverse;
    const float v = p1 * inverse;
    const float wx = z * a20 + b2 * sx;
    const float wy = z * a21 + b2 * sy;
    const float j00 = ((z * a00 + b0 * sx) - u * wx) * inverse;
    const float j01 = ((z * a01 + b0 * sy) - u * wy) * inverse;
    const float j10 = ((z * a10 + b1 * sx) - v * wx) * inverse;
    const float j11 = ((z * a11 + b1 * sy) - v * wy) * inverse;
    float hx = half_size * (std::fabs(j00) + std::fabs(j01));
    float hy = half_size * (std::fabs(j10) + std::fabs(j11));
    hx = hx > 0.5F ? hx : 0.5F;  // also for NaN
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
    const bool kept = keep == nullptr || keep[i] != 0;
    const bool draws = kept & (z > 0.0F) & (p2 > 0.0F) & (p2 <= max_depth) & (x0 <= x1) & (y0 <= y1) & (x0 <= last_x) &
                       (x1 >= 0.0F) & (y0 <= last_y) & (y1 >= 0.0F) & (std::fabs(u) <= 1e9F) & (std::fabs(v) <= 1e9F);
    out.x0[static_cast<std::size_t>(i)] = draws ? static_cast<std::int32_t>(x0) : 0;
    out.x1[static_cast<std::size_t>(i)] = draws ? static_cast<std::int32_t>(x1) : -1;
    out.y0[static_cast<std::size_t>(i)] = draws ? static_cast<std::int32_t>(y0) : 0;
    out.y1[static_cast<std::size_t>(i)] = draws ? static_cast<std::int32_t>(y1) : -1;
    out.depth[static_cast<std::size_t>(i)] = p2;
  }
}

}  // namespace uwv::detail
