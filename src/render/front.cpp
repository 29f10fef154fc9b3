// SPDX-License-Identifier: Apache-2.0
// Step 2 of Algorithm 1: which points face the target camera.
#include <cmath>

#include "uwv/core/simd.h"
#include "uwv/render/occlusion.h"

namespace uwv {
namespace {

/// The target's centre in the source's frame and what turns a slope into a normal there.
struct FrontTest {
  float cx, cy;  ///< Principal point, so that (x + 0.5 - cx) is what the normal needs.
  float fx, fy, inverse_fx, inverse_fy;
  float centre_x, centre_y, centre_z;
  float cos_alpha;
};

// N = -(fx*sx, fy*sy, 1 - sx*(x-cx) - sy*(y-cy)) points to the source camera and N . p = -z for the pixel's point p, so
// with C the target's centre  n . v > cos(alpha)  becomes  N . C + z > cos(alpha) * |N| * |C - p|.
UWV_SIMD_CLONES void front_of_row(const FrontTest& t, int y, int width, const float* depth, const Slope* slopes,
                                  std::uint8_t* out) {
  const float dy = static_cast<float>(y) + 0.5F - t.cy;
  for (int x = 0; x < width; ++x) {
    const float z = depth[x];
    const float sx = slopes[x].x, sy = slopes[x].y;
    const float dx = static_cast<float>(x) + 0.5F - t.cx;
    const float nx = -t.fx * sx, ny = -t.fy * sy, nz = sx * dx + sy * dy - 1.0F;
    const float vx = t.centre_x - z * dx * t.inverse_fx;
    const float vy = t.centre_y - z * dy * t.inverse_fy;
    const float vz = t.centre_z - z;
    const float facing = nx * t.centre_x + ny * t.centre_y + nz * t.centre_z + z;
    const float lengths = std::sqrt((nx * nx + ny * ny + nz * nz) * (vx * vx + vy * vy + vz * vz));
    out[x] = static_cast<std::uint8_t>((z > 0.0F) & (facing > t.cos_alpha * lengths));
  }
}

}  // namespace

ValidityMask front_mask(const PointGrid& points, const Camera& target, double cos_alpha, ThreadPool& pool) {
  ValidityMask front;
  front_mask(points, target, cos_alpha, pool, front);
  return front;
}

void front_mask(const PointGrid& points, const Camera& target, double cos_alpha, ThreadPool& pool, ValidityMask& out) {
  points.check();
  const Intrinsics& k = points.camera.intrinsics;
  const Eigen::Vector3f centre = target_from_source(points.camera, target).translation.cast<float>();
  FrontTest test{};
  test.cx = static_cast<float>(k.cx);
  test.cy = static_cast<float>(k.cy);
  test.fx = static_cast<float>(k.fx);
  test.fy = static_cast<float>(k.fy);
  test.inverse_fx = static_cast<float>(1 / k.fx);
  test.inverse_fy = static_cast<float>(1 / k.fy);
  test.centre_x = centre.x();
  test.centre_y = centre.y();
  test.centre_z = centre.z();
  test.cos_alpha = static_cast<float>(cos_alpha);
  out.resize(points.camera.size);
  const SlopeMap facing_camera = points.slopes != nullptr ? SlopeMap() : SlopeMap(points.camera.size.width, 1);
  pool.for_ranges(0, out.height(), 16, [&](int from, int to) {
    for (int y = from; y < to; ++y)
      front_of_row(test, y, out.width(), points.depth->row(y),
                   points.slopes != nullptr ? points.slopes->row(y) : facing_camera.data(), out.row(y));
  });
}

}  // namespace uwv
