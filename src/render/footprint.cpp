// SPDX-License-Identifier: Apache-2.0
#include "render/footprint.h"

#include <cmath>

#include "uwv/core/simd.h"

namespace uwv::detail {
namespace {

constexpr std::int32_t nowhere = 65536;  // larger than any target

constexpr Slope facing_camera[block_size] = {};

}  // namespace

UWV_SIMD_CLONES void mask_depths(const float* depth, const std::uint8_t* keep, int count, float* out) {
  for (int i = 0; i < count; ++i) out[i] = keep[i] != 0 ? depth[i] : 0.0F;
}

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
  const float min_half = limits.min_half, max_half = limits.max_half;
  const float last_x = limits.width - 1.0F, last_y = limits.height - 1.0F;
  const Slope* slope_of = slopes != nullptr ? slopes : facing_camera;
  alignas(64) std::array<float, block_size> depth_if_kept;
  const float* z_of = depth;
  if (keep != nullptr) {
    mask_depths(depth, keep, count, depth_if_kept.data());
    z_of = depth_if_kept.data();
  }
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
    hx = hx > min_half ? hx : min_half;
    hy = hy > min_half ? hy : min_half;
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
    // Clamped rectangles that miss the picture have x0 > x1 or y0 > y1. NaN passes the clamps, but not |u| <= 1e9.
    const bool draws = has_size & (z > 0.0F) & (p2 > 0.0F) & (p2 <= max_depth) & (x0 <= x1) & (y0 <= y1) &
                       (std::fabs(u) <= 1e9F) & (std::fabs(v) <= 1e9F);
    out_x0[i] = draws ? static_cast<std::int32_t>(x0) : nowhere;
    out_x1[i] = draws ? static_cast<std::int32_t>(x1) : -1;
    out_y0[i] = draws ? static_cast<std::int32_t>(y0) : nowhere;
    out_y1[i] = draws ? static_cast<std::int32_t>(y1) : -1;
    out_depth[i] = p2;
  }
}

UWV_SIMD_CLONES BlockExtent extent_of_block(const Footprints& footprints, int count) {
  std::int32_t x0 = nowhere, x1 = -1, y0 = nowhere, y1 = -1, wider = 0, taller = 0;
  const std::int32_t* fx0 = footprints.x0.data();
  const std::int32_t* fx1 = footprints.x1.data();
  const std::int32_t* fy0 = footprints.y0.data();
  const std::int32_t* fy1 = footprints.y1.data();
  for (int i = 0; i < count; ++i) {
    x0 = fx0[i] < x0 ? fx0[i] : x0;
    x1 = fx1[i] > x1 ? fx1[i] : x1;
    y0 = fy0[i] < y0 ? fy0[i] : y0;
    y1 = fy1[i] > y1 ? fy1[i] : y1;
    wider = fx1[i] - fx0[i] > wider ? fx1[i] - fx0[i] : wider;
    taller = fy1[i] - fy0[i] > taller ? fy1[i] - fy0[i] : taller;
  }
  return {{x0, x1, y0, y1}, wider, taller};
}

UWV_SIMD_CLONES void corners_of_block(const Footprints& footprints, Size target, int count, Corners& out) {
  const auto width = static_cast<std::uint32_t>(target.width);
  const std::uint32_t pixels = width * static_cast<std::uint32_t>(target.height);
  const std::int32_t* fx0 = footprints.x0.data();
  const std::int32_t* fx1 = footprints.x1.data();
  const std::int32_t* fy0 = footprints.y0.data();
  const std::int32_t* fy1 = footprints.y1.data();
  std::uint32_t* top_left = out.index[0].data();
  std::uint32_t* top_right = out.index[1].data();
  std::uint32_t* bottom_left = out.index[2].data();
  std::uint32_t* bottom_right = out.index[3].data();
#pragma GCC ivdep  // inputs and outputs never overlap
  for (int i = 0; i < count; ++i) {
    const auto x0 = static_cast<std::uint32_t>(fx0[i]), x1 = static_cast<std::uint32_t>(fx1[i]);
    const std::uint32_t top = static_cast<std::uint32_t>(fy0[i]) * width;
    const std::uint32_t bottom = static_cast<std::uint32_t>(fy1[i]) * width;
    const bool draws = fx1[i] >= fx0[i];
    const std::uint32_t spare = pixels + static_cast<std::uint32_t>(i);
    top_left[i] = draws ? top + x0 : spare;
    top_right[i] = draws ? top + x1 : spare;
    bottom_left[i] = draws ? bottom + x0 : spare;
    bottom_right[i] = draws ? bottom + x1 : spare;
  }
}

}  // namespace uwv::detail
