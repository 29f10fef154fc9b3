// SPDX-License-Identifier: Apache-2.0
// Points that stand for square cells of pixels (PointGrid::cells).
#pragma once

#include <array>

#include "render/point_blocks.h"
#include "uwv/core/thread_pool.h"

namespace uwv::detail {

/// As footprints_of_block, for points with cells: only those that are kept cost anything. A cell's footprint is that of
/// its centre, which lies half a pixel up and left of the point where the cell has more than one pixel; it is a pixel
/// wider, for rounding.
void footprints_of_cells(const WarpMap& map, int x, int y, int count, const BlockOfPoints& points,
                         const FootprintLimits& limits, Footprints& out);

/// The plane a point stands for, in the target: the closed form of surface.h.
class CellPlane {
 public:
  /// Point (x, y) of a grid with the given depth, slope and cell side.
  CellPlane(const WarpMap& map, int x, int y, float depth, const Slope& slope, int side);

  /// Whether the ray through the centre of target pixel (u, v) meets the plane inside the cell; `depth` becomes the
  /// meeting point's depth in the target.
  bool meets(int u, int v, float& depth) const {
    const float cx = static_cast<float>(u) + 0.5F, cy = static_cast<float>(v) + 0.5F;
    const float z = lift_ / (n_[0] * cx + n_[1] * cy + n_[2]);
    const auto& a = map_.a_inverse;
    const float s0 = (a[0][0] * cx + a[0][1] * cy + a[0][2]) * z - map_.k[0];
    const float s1 = (a[1][0] * cx + a[1][1] * cy + a[1][2]) * z - map_.k[1];
    const float s2 = (a[2][0] * cx + a[2][1] * cy + a[2][2]) * z - map_.k[2];
    depth = z;
    return z > 0 && s2 > 0 && s0 >= x0_ * s2 && s0 < x1_ * s2 && s1 >= y0_ * s2 && s1 < y1_ * s2;
  }

 private:
  const WarpMap& map_;
  std::array<float, 3> n_{};
  float lift_ = 0;
  float x0_, x1_, y0_, y1_;  ///< The cell in the source picture.
};

/// Calls put(u, v, depth, code) for every target pixel that the points of a block show. A rectangle around a cell of
/// many pixels would hide much that lies beside the cell, so cells are cut out exactly, with their plane's depth at
/// every pixel.
template <class Put>
void for_cell_pixels(const WarpMap& map, int x, int y, int count, const BlockOfPoints& points, const Footprints& f,
                     const Put& put) {
  for (int i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (f.x1[at] < f.x0[at]) continue;
    const std::uint32_t code = PointCode::pack(x + i, y);
    const int side = points.cells[i];
    const CellPlane plane(map, x + i, y, points.depth[i], points.slopes != nullptr ? points.slopes[i] : Slope{}, side);
    float depth = f.depth[at];
    for (int v = f.y0[at]; v <= f.y1[at]; ++v)
      for (int u = f.x0[at]; u <= f.x1[at]; ++u)
        if (side <= 1 || plane.meets(u, v, depth)) put(u, v, depth, code);
  }
}

/// A cell counts as seen when any of its pixels is: sets `seen` at kept points accordingly.
void spread_over_cells(const Image<std::uint8_t>& cells, const ValidityMask& kept, ThreadPool& pool,
                       ValidityMask& seen);

}  // namespace uwv::detail
