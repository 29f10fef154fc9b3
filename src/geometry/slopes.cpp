// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/slopes.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "uwv/core/depth.h"
#include "uwv/core/simd.h"

namespace uwv {
namespace {

/// Inverse depth of one row, with `margin` zeros (= invalid) before and after it.
void invert_row(const DepthMap& depth, int y, int margin, std::vector<float>& row) {
  row.assign(static_cast<std::size_t>(depth.width()) + 2 * static_cast<std::size_t>(margin), 0.0F);
  if (y < 0 || y >= depth.height()) return;
  const float* z = depth.row(y);
  float* w = row.data() + margin;
  for (int x = 0; x < depth.width(); ++x) w[x] = z[x] > 0 ? 1.0F / z[x] : 0.0F;
}

inline bool joined(float a, float b, float discontinuity) {
  return (a > 0) & (b > 0) & (std::fabs(a - b) <= discontinuity * (a > b ? a : b));
}

/// True when the second step goes on as the first did, give or take half: one surface, not a lone point on the way from
/// one surface to another.
inline bool continues(float first_step, float second_step) {
  const float a = std::fabs(first_step), b = std::fabs(second_step);
  return std::fabs(first_step - second_step) <= 0.5F * (a > b ? a : b);
}

/// Change of inverse depth over one step of the surface through `here`, from the two values before and the two after
/// (0 = invalid). Written with selects instead of branches so that whole rows vectorise.
inline float step_on_surface(float before2, float before, float here, float after, float after2, float discontinuity) {
  const float back = here - before;
  const float ahead = after - here;
  // Both neighbours on one plane: the two steps agree, however steep the plane is.
  const bool straight = (before > 0) & (after > 0) & (std::fabs(ahead - back) <= 0.25F * discontinuity * here);
  const bool back_usable = joined(here, before, discontinuity) & (before2 > 0) & continues(back, before - before2);
  const bool ahead_usable = joined(here, after, discontinuity) & (after2 > 0) & continues(ahead, after2 - after);
  const float back_or_zero = back_usable ? back : 0.0F;
  const float ahead_or_zero = ahead_usable ? ahead : 0.0F;
  // At a crease or a small step the flatter side is the one that does not cross it.
  const bool use_back = back_usable & (!ahead_usable | (std::fabs(back) <= std::fabs(ahead)));
  const float one_sided = use_back ? back_or_zero : ahead_or_zero;
  return straight ? 0.5F * (back + ahead) : one_sided;
}

/// Five rows of inverse depth, `radius` apart, each with 2 * radius zeros on both sides.
struct RowStencil {
  const float *above2, *above, *here, *below, *below2;
};

UWV_SIMD_CLONES void slopes_of_row(const RowStencil& rows, int radius, int width, float discontinuity, Slope* out) {
  const float per_pixel = 1.0F / static_cast<float>(radius);
  const float *above2 = rows.above2, *above = rows.above, *here = rows.here, *below = rows.below, *below2 = rows.below2;
#pragma GCC ivdep  // inputs and outputs never overlap
  for (int x = 0; x < width; ++x) {
    const int i = x + 2 * radius;
    const float w = here[i];
    const float scale = w > 0 ? per_pixel / w : 0.0F;
    const float dx = step_on_surface(here[i - 2 * radius], here[i - radius], w, here[i + radius], here[i + 2 * radius],
                                     discontinuity);
    const float dy = step_on_surface(above2[i], above[i], w, below[i], below2[i], discontinuity);
    out[x].x = scale > 0 ? dx * scale : 0.0F;
    out[x].y = scale > 0 ? dy * scale : 0.0F;
  }
}

/// Calls finish(y, slopes of the row) for every row, while it is still in the processor's cache.
template <class Finish>
void slopes_of_rows(const DepthMap& depth, const SlopeOptions& options, ThreadPool& pool, SlopeMap& out,
                    const Finish& finish) {
  options.check();
  out.resize(depth.size());
  const int r = options.radius;
  const int kept_rows = 4 * r + 1;
  const float discontinuity = options.discontinuity * static_cast<float>(r);
  pool.for_ranges(0, depth.height(), 16, [&](int from, int to) {
    std::vector<std::vector<float>> rows(static_cast<std::size_t>(kept_rows));
    const auto row_at = [&](int y) -> std::vector<float>& {
      return rows[static_cast<std::size_t>((y + kept_rows) % kept_rows)];
    };
    for (int y = from - 2 * r; y < from + 2 * r; ++y) invert_row(depth, y, 2 * r, row_at(y));
    for (int y = from; y < to; ++y) {
      invert_row(depth, y + 2 * r, 2 * r, row_at(y + 2 * r));
      const RowStencil stencil{row_at(y - 2 * r).data(), row_at(y - r).data(), row_at(y).data(), row_at(y + r).data(),
                               row_at(y + 2 * r).data()};
      slopes_of_row(stencil, r, depth.width(), discontinuity, out.row(y));
      finish(y, out.row(y));
    }
  });
}

/// What limit_row needs of the lens; `limit` is 1 / cos^2 of the largest tilt.
struct Tilt {
  float fx, fy, inverse_fx, inverse_fy, cx, cy, limit;
};

// N = (fx*sx, fy*sy, 1 - sx*dx - sy*dy) is a normal with N . ray = 1, so the cosine of the tilt is 1 / (|N| |ray|).
UWV_SIMD_CLONES void limit_row(const Tilt& t, int y, int width, Slope* slopes) {
  const float fx = t.fx, fy = t.fy, inverse_fx = t.inverse_fx, cx = t.cx, limit = t.limit;
  const float dy = static_cast<float>(y) + 0.5F - t.cy;
  const float ray_y = dy * t.inverse_fy;
#pragma GCC ivdep
  for (int x = 0; x < width; ++x) {
    const float sx = slopes[x].x, sy = slopes[x].y;
    const float dx = static_cast<float>(x) + 0.5F - cx;
    const float nx = fx * sx, ny = fy * sy, nz = 1.0F - sx * dx - sy * dy;
    const float ray_x = dx * inverse_fx;
    const bool keep = (nx * nx + ny * ny + nz * nz) * (ray_x * ray_x + ray_y * ray_y + 1.0F) <= limit;
    slopes[x].x = keep ? sx : 0.0F;
    slopes[x].y = keep ? sy : 0.0F;
  }
}

/// limit_tilt() for a row.
class TiltTest {
 public:
  TiltTest(const Intrinsics& k, double max_tilt) {
    const double cosine = std::cos(max_tilt);
    off_ = cosine < 1e-6;
    tilt_ = {static_cast<float>(k.fx),
             static_cast<float>(k.fy),
             static_cast<float>(1 / k.fx),
             static_cast<float>(1 / k.fy),
             static_cast<float>(k.cx),
             static_cast<float>(k.cy),
             static_cast<float>(1 / (cosine * cosine))};
  }
  void limit(int y, int width, Slope* slopes) const {
    if (!off_) limit_row(tilt_, y, width, slopes);
  }

 private:
  bool off_;
  Tilt tilt_;
};

}  // namespace

void SlopeOptions::check() const {
  require(discontinuity > 0 && discontinuity < 1, "slope discontinuity {} is outside (0, 1)", discontinuity);
  require(radius >= 1 && radius <= 16, "slope radius {} is outside 1..16", radius);
  require(max_tilt > 0 && max_tilt <= std::numbers::pi / 2 + 1e-9, "max_tilt {} rad is outside (0, pi/2]", max_tilt);
}

SlopeMap slopes_from_depth(const DepthMap& depth, const SlopeOptions& options, ThreadPool& pool) {
  SlopeMap slopes;
  slopes_of_rows(depth, options, pool, slopes, [](int, Slope*) {});
  return slopes;
}

void limited_slopes_from_depth(const DepthMap& depth, const Intrinsics& intrinsics, const SlopeOptions& options,
                               ThreadPool& pool, SlopeMap& out) {
  const TiltTest test(intrinsics, options.max_tilt);
  slopes_of_rows(depth, options, pool, out, [&](int y, Slope* row) { test.limit(y, depth.width(), row); });
}

void limit_tilt(SlopeMap& slopes, const Intrinsics& intrinsics, double max_tilt, ThreadPool& pool) {
  const TiltTest test(intrinsics, max_tilt);
  pool.for_ranges(0, slopes.height(), 32, [&](int from, int to) {
    for (int y = from; y < to; ++y) test.limit(y, slopes.width(), slopes.row(y));
  });
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
