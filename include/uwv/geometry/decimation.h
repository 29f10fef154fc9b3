// SPDX-License-Identifier: Apache-2.0
// Fewer points where a surface is flat: one point with a plane stands for a square cell of pixels.
//
// Cells come from a quadtree over the picture. On a plane inverse depth is affine in the pixel, so a cell is replaced
// by the affine fit to its inverse depths, and only if no pixel of it moves by more than `max_error` pixels in any of
// the pictures it will be drawn into. The bound is checked at every pixel, not estimated.
#pragma once

#include <cstdint>
#include <span>

#include "uwv/core/camera.h"
#include "uwv/core/image.h"
#include "uwv/core/mask.h"
#include "uwv/core/thread_pool.h"
#include "uwv/geometry/slopes.h"

namespace uwv {

struct DecimationOptions {
  /// Largest shift in pixels of any surface point in any target picture. A quarter of a pixel is below what the
  /// footprint of a point rounds away; larger: fewer points.
  double max_error = 0.25;
  /// Largest side of a cell in pixels: 1 (keeps every point), 4, 8, 16, 32 or 64. There are no cells of 2 x 2: a plane
  /// fits them even across the edge between two surfaces.
  int max_cell = 16;
  /// Where colours are given: cells whose colours differ by more than this in a channel are divided, since a point has
  /// one colour. 255 = colours do not matter (for renderers that look colours up in the picture).
  int max_colour_difference = 24;
  /// Throws std::invalid_argument when a value is out of range.
  void check() const;
};

/// The points that are left. A point at pixel (x, y) with cell side s > 0 stands for the s x s pixels from
/// (x - x % s, y - y % s) on; its plane is 1/z(u, v) = (1 + slope.x * (u - x) + slope.y * (v - y)) / depth(x, y).
struct DecimatedDepth {
  ValidityMask kept;         ///< 1 = a point.
  Image<std::uint8_t> cell;  ///< Side of its cell, its footprint in pixels; 0 where there is no point.
  DepthMap depth;            ///< Of its plane at the pixel's centre; 0 where there is no point.
  SlopeMap slopes;           ///< Of its plane; {0, 0} for single pixels, whose tilt is that of the full map.
  double kept_share = 0;     ///< Points of all valid depths; 1 when nothing was saved, 0 when there are none.
};

/// `targets`: the cameras it will be drawn from; a few that are farthest from the source will do, since the shift grows
/// with distance. Points that a target cannot see (behind it) are not bound by it; without any target cells are as
/// large as they can be without mixing valid and invalid depths (and colours). `colours`: null, or sized as the depth.
/// Throws std::invalid_argument when sizes disagree. Exact in any unit of length; the same on every number of threads.
DecimatedDepth decimate_depth(const DepthMap& depth, const Camera& source, std::span<const Camera> targets,
                              const DecimationOptions& options, ThreadPool& pool, const ImageRgb* colours = nullptr);

}  // namespace uwv
