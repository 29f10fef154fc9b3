// SPDX-License-Identifier: Apache-2.0
#include "render/surface.h"

#include <cmath>

#include "render/landing.h"
#include "render/surfels.h"
#include "uwv/core/simd.h"

namespace uwv::detail {
namespace {

/// Which points of a block lie no deeper than the surface they land on. `hidden_by` is that surface's depth at the
/// centre of the pixel (0 = none) and `slope` its slope there, for each point.
struct SurfaceThere {
  alignas(64) std::array<float, block_size> depth, sx, sy;
};

UWV_SIMD_CLONES void compare_with_surface(const Landings& landings, const SurfaceThere& surface, float tolerance,
                                          int count, std::uint8_t* out) {
  const float* u = landings.u.data();
  const float* v = landings.v.data();
  const float* depth = landings.depth.data();
  const float* centre = surface.depth.data();
  const float* sx = surface.sx.data();
  const float* sy = surface.sy.data();
  const float limit = 1.0F + tolerance;
  for (int i = 0; i < count; ++i) {
    const float bend = 1.0F + sx[i] * (u[i] - std::floor(u[i]) - 0.5F) + sy[i] * (v[i] - std::floor(v[i]) - 0.5F);
    const float there = bend > 0.25F ? centre[i] / bend : centre[i];
    // An empty pixel hides nothing; a point outside the picture has a negative surface.
    const bool visible = (centre[i] == 0.0F) | ((centre[i] > 0.0F) & (depth[i] <= there * limit));
    out[i] = static_cast<std::uint8_t>(visible);
  }
}

}  // namespace

void surface_geometry(const PointGrid& points, const Camera& target, const ZBuffer& zbuffer, ThreadPool& pool,
                      DepthMap& depth, SlopeMap* slopes) {
  depth.resize(target.size);
  if (slopes != nullptr) slopes->resize(target.size);
  const auto empty = [&](int y, int x, int count) {
    std::fill_n(depth.row(y) + x, count, 0.0F);
    if (slopes != nullptr) std::fill_n(slopes->row(y) + x, count, Slope{});
  };
  const auto emit = [&](int y, int x, int count, const Patches&, const Surfels& surfels) {
    std::copy_n(surfels.depth.begin(), count, depth.row(y) + x);
    if (slopes == nullptr) return;
    Slope* row = slopes->row(y) + x;
    for (int i = 0; i < count; ++i)
      row[i] = {surfels.sx[static_cast<std::size_t>(i)], surfels.sy[static_cast<std::size_t>(i)]};
  };
  for_surfels(points, target, zbuffer, pool, emit, empty);
}

void visible_by_ztest(const PointGrid& points, const Camera& target, const DepthMap& depth, const SlopeMap& slopes,
                      float tolerance, ThreadPool& pool, ValidityMask& out) {
  const WarpMap map = WarpMap::between(points.camera, target);
  const Size size = points.camera.size;
  out.resize(size);
  pool.for_ranges(0, size.height, 8, [&](int from, int to) {
    Landings landings;
    SurfaceThere surface;
    for (int y = from; y < to; ++y)
      for (int x = 0; x < size.width; x += block_size) {
        const int count = std::min(block_size, size.width - x);
        land_block(map, x, y, count, points.depth->row(y) + x,
                   points.keep != nullptr ? points.keep->row(y) + x : nullptr, target.size, landings);
        for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
          const std::int32_t at = landings.pixel[i];
          const Slope slope = at >= 0 ? slopes.data()[at] : Slope{};
          surface.depth[i] = at >= 0 ? depth.data()[at] : -1.0F;
          surface.sx[i] = slope.x;
          surface.sy[i] = slope.y;
        }
        compare_with_surface(landings, surface, tolerance, count, out.row(y) + x);
      }
  });
}

}  // namespace uwv::detail
