// SPDX-License-Identifier: Apache-2.0
// The local tilt of the surface seen at each pixel, and the normals that follow from it.
//
// On a plane, inverse depth 1/z is an affine function of the pixel. A *slope* is its relative gradient there,
//     slope = z * d(1/z)/d(x, y) = -d(ln z)/d(x, y)      [1 / pixel],
// which has no unit of length (equal for a toy and for a mountain), is exact on planes at any tilt, and gives in closed
// form the two things the renderer needs: the surface normal, and how much a pixel's patch grows and shears in another
// camera. Paper: ComputeNormals of Algorithm 1 (the paper leaves the method open; the official code uses a network).
#pragma once

#include <Eigen/Core>

#include "uwv/core/camera.h"
#include "uwv/core/image.h"
#include "uwv/core/thread_pool.h"

namespace uwv {

/// Relative gradient of inverse depth at a pixel, per pixel in x and y. {0, 0} = parallel to the picture plane.
struct Slope {
  float x = 0, y = 0;
  friend bool operator==(const Slope&, const Slope&) = default;
};
using SlopeMap = Image<Slope>;

/// How slopes are taken from depth.
struct SlopeOptions {
  /// Neighbours whose depths differ by more than this share of the nearer one lie on different surfaces. 0.1 separates
  /// objects in ordinary scenes and still follows a floor seen at 5 degrees in a 480-row picture.
  float discontinuity = 0.1F;
  /// Pixels to each side that are looked at. 1 is sharpest; 2 or 3 average away the noise of measured depth.
  int radius = 1;
  /// Surfaces seen at more than this angle from head-on (radians) are taken for what estimators smear between a near
  /// and a far surface: limit_tilt() lets them face the camera, so that they stay the dots they are instead of growing
  /// into flags when the camera moves. pi/2 turns that off. 86 degrees leaves real floors and walls alone.
  double max_tilt = 1.5;
  /// Throws std::invalid_argument when a value is out of range.
  void check() const;
};

/// Slopes of every pixel of a depth map (0 = invalid depth). Differences are taken within one surface only: across a
/// depth edge the side that continues smoothly is used, and a pixel without a usable neighbour gets {0, 0}.
SlopeMap slopes_from_depth(const DepthMap& depth, const SlopeOptions& options, ThreadPool& pool);
/// The same with limit_tilt(), in one pass and into a map that is used again and again.
void limited_slopes_from_depth(const DepthMap& depth, const Intrinsics& intrinsics, const SlopeOptions& options,
                               ThreadPool& pool, SlopeMap& out);

/// Sets slopes that tilt their patch by more than `max_tilt` radians away from the line of sight to {0, 0}.
void limit_tilt(SlopeMap& slopes, const Intrinsics& intrinsics, double max_tilt, ThreadPool& pool);

/// Unit normals in the camera's frame, as Eigen::Vector3f; (0, 0, 0) = unknown.
using NormalMap = Image<Eigen::Vector3f>;

/// The normal of a slope at pixel centre (x + 0.5, y + 0.5): unit length, camera frame, turned towards the camera.
Eigen::Vector3f normal_from_slope(const Slope& slope, int x, int y, const Intrinsics& intrinsics);

/// Slopes that reproduce imported normals (a network's, say; camera frame, either sign). Normals within half a degree
/// of edge-on, unknown or not finite give {0, 0}.
SlopeMap slopes_from_normals(const NormalMap& normals, const Intrinsics& intrinsics);

}  // namespace uwv
