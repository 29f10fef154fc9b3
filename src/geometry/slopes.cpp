// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/slopes.h"

#include <cmath>
#include <vector>

#include "uwv/core/depth.h"
#include "uwv/core/simd.h"

namespace uwv {
namespace {

/// Inverse depth of one row, with `margin` zeros (= invalid) before and after it.
void invert_row(const DepthMap& depth, int y, int margin, std::vector<float>& row) {
  row.assign(static_cast<std::size_t>(depth.width() + 2 * margin), 0.0F);
  if (y < 0 || y >= depth.height()) return;
  const float* z = depth.row(y);
  float* w = row.data() + margin;
  for (int x = 0; x < depth.width(); ++x) w[x] = z[x] > 0 ? 1.0F / z[x] : 0.0F;
}

/// Change of inverse depth over one step of the surface through `here`, from its neighbours a step before and after
/// (0 = invalid). Written with selects instead of branches so that whole rows vectorise.
inline float step_on_surface(float before, float here, float after, float discontinuity) {
  const float back = here - before;
  const float ahead = after - here;
  const bool has_before = before > 0;
  const bool has_after = after > 0;
  // Both neighbours on one plane: the two steps agree, however steep the plane is.
  const bool straight = has_before & has_after & (std::fabs(ahead - back) <= 0.25F * discontinuity * here);
  const bool back_joined = has_before & (std::fabs(back) <= discontinuity * (here > before ? here : before));
  const bool ahead_joined = has_after & (std::fabs(ahead) <= discontinuity * (here > after ? here : after));
  const float back_or_zero = back_joined ? back : 0.0F;
  const float ahead_or_zero = ahead_joined ? ahead : 0.0F;
  // At a crease or a small step the flatter side is the one that does not cross it.
  const bool use_back = back_joined & (!ahead_joined | (std::fabs(back) <= std::fabs(ahead)));
  const float one_sided = use_back ? back_or_zero : ahead_or_zero;
  return straight ? 0.5F * (back + ahead) : one_sided;
}

UWV_SIMD_CLONES void slopes_of_row(const float* above, const float* here, const float* below, int margin, int width,
                                   float discontinuity, Slope* out) {
  const float per_pixel = 1.0F / static_cast<float>(margin);
#pragma GCC ivdep  // inputs and outputs never overlap
  for (int x = 0; x < width; ++x) {
    const int i = x + margin;
    const float w = here[i];
    const float scale = w > 0 ? per_pixel / w : 0.0F;
    const float dx = step_on_surface(here[i - margin], w, here[i + margin], discontinuity);
    const float dy = step_on_surface(above[i], w, below[i], discontinuity);
    out[x].x = scale > 0 ? dx * scale : 0.0F;
    out[x].y = scale > 0 ? dy * scale : 0.0F;
  }
}

}  // namespace

void SlopeOptions::check() const {
  require(discontinuity > 0 && discontinuity < 1, "slope discontinuity {} is outside (0, 1)", discontinuity);
  require(radius >= 1 && radius <= 16, "slope radius {} is outside 1..16", radius);
}

SlopeMap slopes_from_depth(const DepthMap& depth, const SlopeOptions& options, ThreadPool& pool) {
  options.check();
  SlopeMap slopes(depth.size());
  const int r = options.radius;
  const float discontinuity = options.discontinuity * static_cast<float>(r);
  pool.for_ranges(0, depth.height(), 16, [&](int from, int to) {
    std::vector<std::vector<float>> rows(static_cast<std::size_t>(2 * r + 1));
    const auto row_at = [&](int y) -> std::vector<float>& {
      return rows[static_cast<std::size_t>((y + 2 * r + 1) % (2 * r + 1))];
    };
    for (int y = from - r; y < from + r; ++y) invert_row(depth, y, r, row_at(y));
    for (int y = from; y < to; ++y) {
      invert_row(depth, y + r, r, row_at(y + r));
      slopes_of_row(row_at(y - r).data(), row_at(y).data(), row_at(y + r).data(), r, depth.width(), discontinuity,
                    slopes.row(y));
    }
  });
  return slopes;
}

Eigen::Vector3f normal_from_slope(const Slope& slope, int x, int y, const Intrinsics& k) {
  const double sx = slope.x, sy = slope.y;
  const Eigen::Vector3d towards_camera(-sx * k.fx, -sy * k.fy, sx * (x + 0.5 - k.cx) + sy * (y + 0.5 - k.cy) - 1.0);
  return towards_camera.normalized().cast<float>();
}

SlopeMap slopes_from_normals(const NormalMap& normals, const Intrinsics& k) {
  SlopeMap slopes(normals.size());
  for (int y = 0; y < normals.height(); ++y) {
    for (int x = 0; x < normals.width(); ++x) {
      const Eigen::Vector3d n = normals(x, y).cast<double>();
      const Eigen::Vector3d ray((x + 0.5 - k.cx) / k.fx, (y + 0.5 - k.cy) / k.fy, 1.0);
      const double along = n.dot(ray);
      // Edge-on or unknown (0,0,0) normals would give an unbounded slope.
      if (!n.allFinite() || !(std::abs(along) > 0.0087 * n.norm() * ray.norm()) || n.squaredNorm() < 1e-12) continue;
      slopes(x, y) = {static_cast<float>(n.x() / (k.fx * along)), static_cast<float>(n.y() / (k.fy * along))};
    }
  }
  return slopes;
}

}  // namespace uwv
