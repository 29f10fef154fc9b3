// SPDX-License-Identifier: Apache-2.0
// Where the pixels' rays meet the patches that won them, a block of pixels at a time (the closed form is in surface.h).
#pragma once

#include <algorithm>
#include <array>

#include "render/footprint.h"

namespace uwv::detail {

/// How far from the winner's centre, in source pixels, its plane is trusted. Its own patch ends at 0.5; a little more
/// absorbs the bounding rectangle's corners and rounding.
inline constexpr float patch_reach = 0.75F;
/// The same for a point that stands for a cell of pixels: its pixel is the one right of and below the cell's centre.
constexpr float cell_reach(int side) { return side > 1 ? 0.5F * static_cast<float>(side) + patch_reach : patch_reach; }

/// The winners of a block of target pixels, gathered from the source so that the arithmetic can run in SIMD lanes.
struct Patches {
  alignas(64) std::array<std::int32_t, block_size> index;  ///< y * width + x in the source; 0 where there is no winner.
  alignas(64) std::array<float, block_size> x, y;          ///< Pixel centre in the source.
  alignas(64) std::array<float, block_size> reach;         ///< How far from there the plane is trusted.
  alignas(64) std::array<float, block_size> z, sx, sy;     ///< Depth (0 = no winner) and slope there.
};

/// Where the pixels' rays meet the patches.
struct Surfels {
  alignas(64) std::array<float, block_size> depth;   ///< In the target; 0 = nothing.
  alignas(64) std::array<float, block_size> sx, sy;  ///< Slope in the target.
  alignas(64) std::array<float, block_size> x, y;    ///< Position in the source picture.
};

void gather_patches(const PointGrid& points, const std::uint32_t* winner, int count, Patches& out);

/// Surfels of target pixels (x, y) .. (x + count - 1, y).
void meet_patches(const WarpMap& map, int x, int y, int count, const Patches& patches, Surfels& out);

/// Calls emit(y, x, count, patches, surfels) for every block of the target that shows something, and empty(y, x, count)
/// for the others.
template <class Emit, class Empty>
void for_surfels(const PointGrid& points, const Camera& target, const ZBuffer& zbuffer, ThreadPool& pool,
                 const Emit& emit, const Empty& empty) {
  const WarpMap map = WarpMap::between(points.camera, target);
  pool.for_ranges(0, target.size.height, 8, [&](int from, int to) {
    Patches patches;
    Surfels surfels;
    for (int y = from; y < to; ++y)
      for (int x = 0; x < target.size.width; x += block_size) {
        const int count = std::min(block_size, target.size.width - x);
        const std::uint32_t* winner = zbuffer.winner.row(y) + x;
        if (std::all_of(winner, winner + count, [](std::uint32_t code) { return code == PointCode::none; })) {
          empty(y, x, count);
          continue;
        }
        gather_patches(points, winner, count, patches);
        meet_patches(map, x, y, count, patches, surfels);
        emit(y, x, count, patches, surfels);
      }
  });
}

}  // namespace uwv::detail
