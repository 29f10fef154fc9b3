// SPDX-License-Identifier: Apache-2.0
// Where the CPU renderer's blocks of points come from: a grid in memory, or the surface a z-buffer shows.
#pragma once

#include <array>

#include "render/surfels.h"

namespace uwv::detail {

/// What the points of a block are made of; all but `depth` may be null.
struct BlockOfPoints {
  const float* depth;
  const Slope* slopes;
  const std::uint8_t* keep;
  const std::uint8_t* cells = nullptr;
};

/// The points of a grid.
struct GridBlocks {
  const PointGrid& grid;

  BlockOfPoints at(int x, int y, int) {
    return {grid.depth->row(y) + x, grid.slopes != nullptr ? grid.slopes->row(y) + x : nullptr,
            grid.keep != nullptr ? grid.keep->row(y) + x : nullptr,
            grid.cells != nullptr ? grid.cells->row(y) + x : nullptr};
  }
};

/// The surface a z-buffer shows, as points of its own camera; made block by block, it never goes through memory.
struct SurfaceBlocks {
  const PointGrid& grid;
  const ZBuffer& zbuffer;
  WarpMap map;  ///< From the grid into the z-buffer's camera.
  Patches patches;
  Surfels surfels;
  std::array<Slope, block_size> slopes;

  SurfaceBlocks(const PointGrid& points, const Camera& camera, const ZBuffer& seen)
      : grid(points), zbuffer(seen), map(WarpMap::between(points.camera, camera)) {}

  BlockOfPoints at(int x, int y, int count) {
    gather_patches(grid, zbuffer.winner.row(y) + x, count, patches);
    meet_patches(map, x, y, count, patches, surfels);
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) slopes[i] = {surfels.sx[i], surfels.sy[i]};
    return {surfels.depth.data(), slopes.data(), nullptr};
  }
};

}  // namespace uwv::detail
