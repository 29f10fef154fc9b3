// SPDX-License-Identifier: Apache-2.0
#include "render/landing.h"

#include "uwv/core/simd.h"

namespace uwv::detail {

UWV_SIMD_CLONES void land_block(const WarpMap& map, int x, int y, int count, const float* depth,
                                const std::uint8_t* keep, Size target, Landings& out) {
  const float fy = static_cast<float>(y);
  const float row0 = map.a[0][1] * fy + map.a[0][2];
  const float row1 = map.a[1][1] * fy + map.a[1][2];
  const float row2 = map.a[2][1] * fy + map.a[2][2];
  const float a00 = map.a[0][0], a10 = map.a[1][0], a20 = map.a[2][0];
  const float b0 = map.b[0], b1 = map.b[1], b2 = map.b[2];
  const float width = static_cast<float>(target.width), height = static_cast<float>(target.height);
  alignas(64) std::array<float, block_size> depth_if_kept;
  const float* z_of = depth;
  if (keep != nullptr) {
    mask_depths(depth, keep, count, depth_if_kept.data());
    z_of = depth_if_kept.data();
  }
  float* out_u = out.u.data();
  float* out_v = out.v.data();
  float* out_depth = out.depth.data();
  std::int32_t* out_pixel = out.pixel.data();
#pragma GCC ivdep  // inputs and outputs never overlap
  for (int i = 0; i < count; ++i) {
    const float z = z_of[i];
    const float fx = static_cast<float>(x + i);
    const float p2 = z * (a20 * fx + row2) + b2;
    const float u = (z * (a00 * fx + row0) + b0) / p2;
    const float v = (z * (a10 * fx + row1) + b1) / p2;
    const bool inside = (z > 0.0F) & (p2 > 0.0F) & (u >= 0.0F) & (v >= 0.0F) & (u < width) & (v < height);
    const float column = inside ? u : 0.0F, line = inside ? v : 0.0F;
    out_u[i] = u;
    out_v[i] = v;
    out_depth[i] = p2;
    const std::int32_t pixel = static_cast<std::int32_t>(line) * target.width + static_cast<std::int32_t>(column);
    out_pixel[i] = inside ? pixel : -1;
  }
}

}  // namespace uwv::detail
