// SPDX-License-Identifier: Apache-2.0
#include "mesh_raster.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace uwv {
namespace {

/// Pixels whose centres may lie in a triangle: [x0, x1) by [y0, y1).
struct Bounds {
  int x0 = 0, x1 = 0, y0 = 0, y1 = 0;
};

int clamped(double v, int limit) { return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(limit))); }

/// The picture of the part in front of a plane just before the camera. Where an edge passes that plane its picture is
/// far outside or as good as there, so that clipping loses nothing but what no depth could be given to.
Bounds bounds_of(const ViewedTriangle& triangle, const Intrinsics& lens, Size size) {
  double farthest = 0;
  for (const Eigen::Vector3d& x : triangle.corners) farthest = std::max(farthest, x.z());
  const double near = 1e-9 * farthest;
  if (!(near > 0)) return {};
  double low_u = std::numeric_limits<double>::infinity(), low_v = low_u, high_u = -low_u, high_v = -low_u;
  const auto take = [&](const Eigen::Vector3d& x) {
    const double u = lens.fx * x.x() / x.z() + lens.cx, v = lens.fy * x.y() / x.z() + lens.cy;
    low_u = std::min(low_u, u), high_u = std::max(high_u, u);
    low_v = std::min(low_v, v), high_v = std::max(high_v, v);
  };
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d &a = triangle.corners[i], &b = triangle.corners[(i + 1) % 3];
    if (a.z() >= near) take(a);
    if ((a.z() < near) != (b.z() < near)) {
      Eigen::Vector3d crossing = a + (near - a.z()) / (b.z() - a.z()) * (b - a);
      crossing.z() = near;
      take(crossing);
    }
  }
  // One pixel to spare: rounding must not cost a pixel that the exact test would give.
  return {clamped(std::floor(low_u) - 1, size.width), clamped(std::ceil(high_u) + 1, size.width),
          clamped(std::floor(low_v) - 1, size.height), clamped(std::ceil(high_v) + 1, size.height)};
}

}  // namespace

ViewedTriangle::ViewedTriangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c)
    : corners{a, b, c}, edges{b.cross(c), c.cross(a), a.cross(b)}, normal((b - a).cross(c - a)) {
  // The corner next to the origin rounds least.
  const Eigen::Vector3d& next = a.squaredNorm() < b.squaredNorm() ? (a.squaredNorm() < c.squaredNorm() ? a : c)
                                                                  : (b.squaredNorm() < c.squaredNorm() ? b : c);
  offset = normal.dot(next);
}

Eigen::Vector3d ViewedTriangle::weights(const Eigen::Vector3d& direction) const {
  const Eigen::Vector3d shares(edges[0].dot(direction), edges[1].dot(direction), edges[2].dot(direction));
  const double sum = shares.sum();
  return sum == 0 ? Eigen::Vector3d(1, 0, 0) : Eigen::Vector3d(shares / sum);
}

Image<std::int32_t> nearest_triangles(std::span<const ViewedTriangle> triangles, const Intrinsics& intrinsics,
                                      Size size, ThreadPool& pool) {
  std::vector<Bounds> bounds(triangles.size());
  pool.for_ranges(0, static_cast<int>(triangles.size()), 256, [&](int from, int to) {
    for (int i = from; i < to; ++i)
      bounds[static_cast<std::size_t>(i)] = bounds_of(triangles[static_cast<std::size_t>(i)], intrinsics, size);
  });
  Image<std::int32_t> nearest(size, -1);
  Image<double> depth(size, std::numeric_limits<double>::infinity());
  pool.for_ranges(0, size.height, 16, [&](int from, int to) {
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      const Bounds& box = bounds[i];
      for (int y = std::max(from, box.y0); y < std::min(to, box.y1); ++y)
        for (int x = box.x0; x < box.x1; ++x) {
          const double z = triangles[i].depth(unproject(intrinsics, {x + 0.5, y + 0.5}, 1.0));
          if (!(z > 0 && z < depth(x, y))) continue;
          depth(x, y) = z;
          nearest(x, y) = static_cast<std::int32_t>(i);
        }
    }
  });
  return nearest;
}

}  // namespace uwv
