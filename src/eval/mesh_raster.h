// SPDX-License-Identifier: Apache-2.0
// Which triangle a ray through each point of a raster meets first, exactly.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "uwv/core/camera.h"
#include "uwv/core/thread_pool.h"

namespace uwv {

/// A triangle in the camera's frame, ready to be met by rays through the camera's centre (Olano and Greer, "Triangle
/// scan conversion using 2D homogeneous coordinates", 1997): no clipping, no division before a ray meets it.
struct ViewedTriangle {
  ViewedTriangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

  std::array<Eigen::Vector3d, 3> corners;
  std::array<Eigen::Vector3d, 3> edges;  ///< Opposite to each corner: normals of planes through the centre.
  Eigen::Vector3d normal;                ///< Not of unit length.
  double offset = 0;                     ///< normal . x on the triangle.

  /// Depth along a direction with z = 1; 0 = missed or behind.
  double depth(const Eigen::Vector3d& direction) const {
    const double u = edges[0].dot(direction), v = edges[1].dot(direction), w = edges[2].dot(direction);
    const bool inside = (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
    if (!inside) return 0;
    const double along = normal.dot(direction);
    return along == 0 ? 0 : offset / along;
  }
  /// Weights of the corners where the ray meets the plane; they sum up to 1.
  Eigen::Vector3d weights(const Eigen::Vector3d& direction) const;
};

/// At each pixel's centre, the index of the nearest triangle (-1 = none; of equals the first).
Image<std::int32_t> nearest_triangles(std::span<const ViewedTriangle> triangles, const Intrinsics& intrinsics,
                                      Size size, ThreadPool& pool);

}  // namespace uwv
