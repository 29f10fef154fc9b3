// SPDX-License-Identifier: Apache-2.0
// From points to the pixel rectangles they cover: the arithmetic of rasterizer.h, a block of points at a time.
#pragma once

#include <array>
#include <cstdint>

#include "uwv/render/point_grid.h"
#include "uwv/render/rasterizer.h"

namespace uwv::detail {

/// Points handled at once: small enough for what they cover to stay together, large enough to hide the loop's set-up.
inline constexpr int block_size = 64;

/// Covered rectangles of a block of points, inclusive; a point that draws nothing has x1 < x0 and lies beyond every
/// picture, so that the smallest x0 and y0 of a block are those of points that draw.
struct Footprints {
  alignas(64) std::array<std::int32_t, block_size> x0, x1, y0, y1;
  alignas(64) std::array<float, block_size> depth;  ///< p2, in the target.
};

/// The target's bounds and the limits of half a footprint's side.
struct FootprintLimits {
  float width, height;
  float point_size;
  float min_half, max_half;
  FootprintLimits(Size target, const FootprintOptions& options)
      : width(static_cast<float>(target.width)),
        height(static_cast<float>(target.height)),
        point_size(options.point_size),
        min_half(0.5F * options.min_footprint),
        max_half(0.5F * options.max_footprint) {}
};

/// Depths, with 0 for points that are not kept. A loop of its own: bytes among floats would make the compiler unroll
/// the loops over points beyond the registers there are.
void mask_depths(const float* depth, const std::uint8_t* keep, int count, float* out);

/// Footprints of the points (x, y) .. (x + count - 1, y), count <= block_size. The pointers are those of point (x, y);
/// `slopes` and `keep` may be null.
void footprints_of_block(const WarpMap& map, int x, int y, int count, const float* depth, const Slope* slopes,
                         const std::uint8_t* keep, const FootprintLimits& limits, Footprints& out);

/// What a block of points covers altogether, and the sides of its largest footprint minus 1.
struct BlockExtent {
  PixelBox box;
  std::int32_t wider, taller;
};
BlockExtent extent_of_block(const Footprints& footprints, int count);

/// Pixel indices (y * width + x) of the four corners of each footprint: (x0, y0), (x1, y0), (x0, y1), (x1, y1). Points
/// that draw nothing get an index of their own beyond the picture, pixels + i.
struct Corners {
  alignas(64) std::array<std::array<std::uint32_t, block_size>, 4> index;
};
void corners_of_block(const Footprints& footprints, Size target, int count, Corners& out);

}  // namespace uwv::detail
