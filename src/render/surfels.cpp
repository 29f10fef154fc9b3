// SPDX-License-Identifier: Apache-2.0
#include "render/surfels.h"

#include "uwv/core/simd.h"

namespace uwv::detail {
namespace {

inline float clamped(float value, float limit) {
  const float low = value > -limit ? value : -limit;
  return low < limit ? low : limit;
}

UWV_SIMD_CLONES void locate_winners(const std::uint32_t* winner, int source_width, int count, Patches& out) {
  std::int32_t* index = out.index.data();
  float* px = out.x.data();
  float* py = out.y.data();
#pragma GCC ivdep  // inputs and outputs never overlap
  for (int i = 0; i < count; ++i) {
    const std::uint32_t code = winner[i] != PointCode::none ? winner[i] : 0;
    const auto x = static_cast<std::int32_t>(code & 0xFFFFU), y = static_cast<std::int32_t>(code >> 16);
    index[i] = y * source_width + x;
    px[i] = static_cast<float>(x) + 0.5F;
    py[i] = static_cast<float>(y) + 0.5F;
  }
}

}  // namespace

void gather_patches(const PointGrid& points, const std::uint32_t* winner, int count, Patches& out) {
  locate_winners(winner, points.camera.size.width, count, out);
  const float* depth = points.depth->data();
  const Slope* slopes = points.slopes != nullptr ? points.slopes->data() : nullptr;
  const auto below = static_cast<std::size_t>(points.camera.size.width);
  const std::size_t pixels = points.camera.size.pixels();
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); i += 8) {
    const std::size_t at = static_cast<std::size_t>(out.index[i]) + below;
    if (at >= pixels) continue;
    __builtin_prefetch(depth + at);
    if (slopes != nullptr) __builtin_prefetch(slopes + at);
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const auto at = static_cast<std::size_t>(out.index[i]);
    const Slope slope = slopes != nullptr ? slopes[at] : Slope{};
    out.z[i] = winner[i] != PointCode::none ? depth[at] : 0.0F;
    out.sx[i] = slope.x;
    out.sy[i] = slope.y;
  }
  out.reach.fill(patch_reach);
  if (points.cells == nullptr) return;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
    out.reach[i] = cell_reach(points.cells->data()[out.index[i]]);
}

UWV_SIMD_CLONES void meet_patches(const WarpMap& map, int x, int y, int count, const Patches& patches, Surfels& out) {
  const float r00 = map.a_inverse[0][0], r01 = map.a_inverse[0][1], r02 = map.a_inverse[0][2];
  const float r10 = map.a_inverse[1][0], r11 = map.a_inverse[1][1], r12 = map.a_inverse[1][2];
  const float r20 = map.a_inverse[2][0], r21 = map.a_inverse[2][1], r22 = map.a_inverse[2][2];
  const float k0 = map.k[0], k1 = map.k[1], k2 = map.k[2];
  // The forward map's third row without the folded half pixel.
  const float a20 = map.a[2][0], a21 = map.a[2][1], a22 = map.a[2][2] - 0.5F * (a20 + a21), b2 = map.b[2];
  const float cy = static_cast<float>(y) + 0.5F;
  const float* px = patches.x.data();
  const float* py = patches.y.data();
  const float* pz = patches.z.data();
  const float* reach = patches.reach.data();
  const float* psx = patches.sx.data();
  const float* psy = patches.sy.data();
  float* out_depth = out.depth.data();
  float* out_sx = out.sx.data();
  float* out_sy = out.sy.data();
  float* out_x = out.x.data();
  float* out_y = out.y.data();
#pragma GCC ivdep  // inputs and outputs never overlap
  for (int i = 0; i < count; ++i) {
    const float cx = static_cast<float>(x + i) + 0.5F;
    const float xs = px[i], ys = py[i];
    const float z = pz[i];
    const float m0 = psx[i], m1 = psy[i];
    const float m2 = 1.0F - m0 * xs - m1 * ys;
    const float n0 = r00 * m0 + r10 * m1 + r20 * m2;
    const float n1 = r01 * m0 + r11 * m1 + r21 * m2;
    const float n2 = r02 * m0 + r12 * m1 + r22 * m2;
    const float facing = 1.0F / (n0 * cx + n1 * cy + n2);
    const float z_plane = (z + (m0 * k0 + m1 * k1 + m2 * k2)) * facing;
    const float s0 = (r00 * cx + r01 * cy + r02) * z_plane - k0;
    const float s1 = (r10 * cx + r11 * cy + r12) * z_plane - k1;
    const float s2 = 1.0F / ((r20 * cx + r21 * cy + r22) * z_plane - k2);
    // Beyond its own patch a plane proves nothing: stay within reach of the winner.
    const float dx = clamped(s0 * s2 - xs, reach[i]);
    const float dy = clamped(s1 * s2 - ys, reach[i]);
    const float shrink = 1.0F + m0 * dx + m1 * dy;
    const float z_there = z / (shrink > 0.25F ? shrink : 1.0F);
    const float depth = z_there * (a20 * (xs + dx) + a21 * (ys + dy) + a22) + b2;
    const float own_depth = z * (a20 * xs + a21 * ys + a22) + b2;
    const bool hit = z > 0.0F;
    const bool sane = (depth > 0.5F * own_depth) & (depth < 2.0F * own_depth);
    const float limit = 64.0F;
    out_depth[i] = hit ? (sane ? depth : own_depth) : 0.0F;
    out_sx[i] = hit ? clamped(n0 * facing, limit) : 0.0F;
    out_sy[i] = hit ? clamped(n1 * facing, limit) : 0.0F;
    out_x[i] = xs + dx;
    out_y[i] = ys + dy;
  }
}

}  // namespace uwv::detail
