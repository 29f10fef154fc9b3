// SPDX-License-Identifier: Apache-2.0
#include "geometry/mvs/reprojection.h"

#include <algorithm>
#include <cmath>

namespace uwv::mvs {
namespace {

/// Bilinear where the four around agree about one surface, else the nearest; 0 = unknown.
float sample(const InverseDepthMap& map, float u, float v, float tolerance) {
  const float cu = std::clamp(u - 0.5F, 0.0F, static_cast<float>(map.width() - 1));
  const float cv = std::clamp(v - 0.5F, 0.0F, static_cast<float>(map.height() - 1));
  const int x = std::min(static_cast<int>(cu), std::max(map.width() - 2, 0));
  const int y = std::min(static_cast<int>(cv), std::max(map.height() - 2, 0));
  const int x1 = std::min(x + 1, map.width() - 1);
  const int y1 = std::min(y + 1, map.height() - 1);
  const float fx = cu - static_cast<float>(x);
  const float fy = cv - static_cast<float>(y);
  const float a = map(x, y), b = map(x1, y), c = map(x, y1), d = map(x1, y1);
  const float least = std::min(std::min(a, b), std::min(c, d));
  const float most = std::max(std::max(a, b), std::max(c, d));
  if (least > 0 && most - least <= 2 * tolerance * least)
    return (a + fx * (b - a)) * (1 - fy) + (c + fx * (d - c)) * fy;
  return map(fx < 0.5F ? x : x1, fy < 0.5F ? y : y1);
}

}  // namespace

Reprojection make_reprojection(const Camera& from, const Camera& to) {
  const Rigid3 target_from_here = target_from_source(to, from);
  const Eigen::Matrix3d k = to.intrinsics.matrix();
  return {(k * target_from_here.rotation * from.intrinsics.inverse_matrix()).cast<float>(),
          (k * target_from_here.translation).cast<float>()};
}

float agreed_inverse_depth(const Reprojection& to_other, const InverseDepthMap& other, float x, float y, float w,
                           float tolerance) {
  const Eigen::Vector3f p = to_other.pixel_from_pixel * Eigen::Vector3f(x, y, 1) + w * to_other.shift;
  if (!(p.z() > 1e-6F)) return 0;
  const float u = p.x() / p.z();
  const float v = p.y() / p.z();
  if (!(u >= 0 && v >= 0 && u < static_cast<float>(other.width()) && v < static_cast<float>(other.height()))) return 0;
  // Inverse depth in the other view of the point we claim is w / p.z.
  const float claimed = w / p.z();
  const float measured = sample(other, u, v, tolerance);
  if (measured <= 0 || std::abs(measured - claimed) > tolerance * std::min(measured, claimed)) return 0;
  return w * (measured / claimed);
}

}  // namespace uwv::mvs
