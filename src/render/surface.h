// SPDX-License-Identifier: Apache-2.0
// From "which point won this pixel" to the surface behind the pixel: depth, slope and colour exactly at the pixel's
// centre.
//
// A footprint has several pixels and one depth; on a tilted surface that makes stairs. But the winner's patch is a
// plane (depth + slope), and a plane seen from another camera is again a plane, in closed form: with X = (x_s, y_s, 1)
// the winner's pixel centre, m = (sx, sy, 1 - sx*x_s - sy*y_s) and c = (x + 0.5, y + 0.5, 1) the target's pixel centre,
//     n = A^-T m,    z(c) = (z_s + m . k) / (n . c),    slope(c) = (n_0, n_1) / (n . c),
// and the source position behind the pixel is s = A^-1 c z(c) - k, x' = s0/s2, y' = s1/s2.
#pragma once

#include "uwv/render/occlusion.h"
#include "uwv/render/rasterizer.h"

namespace uwv::detail {

/// Depth (and slope, unless null) of the surface at each target pixel's centre; 0 where the z-buffer is empty.
void surface_geometry(const PointGrid& points, const Camera& target, const ZBuffer& zbuffer, ThreadPool& pool,
                      DepthMap& depth, SlopeMap* slopes);

/// The winner's own colour and depth.
void nearest_colour(const ZBuffer& zbuffer, const ImageRgb& source, ThreadPool& pool, RenderedFrame& out);

/// Colour looked up where the pixel's ray meets the winner's plane: bilinear over those of the four source pixels
/// around that lie on the same surface. Also sets out.depth as surface_geometry does.
void resampled_colour(const PointGrid& points, const Camera& target, const ZBuffer& zbuffer, const ImageRgb& source,
                      ThreadPool& pool, RenderedFrame& out);

/// 1 for every source point that no target surface hides: its depth in the target is at most (1 + tolerance) times the
/// depth of the surface there (`depth` and `slopes` as surface_geometry gives them), and it is inside the picture.
void visible_by_ztest(const PointGrid& points, const Camera& target, const DepthMap& depth, const SlopeMap& slopes,
                      float tolerance, ThreadPool& pool, ValidityMask& out);

}  // namespace uwv::detail
