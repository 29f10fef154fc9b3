// SPDX-License-Identifier: Apache-2.0
#include "model/focal_shift.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace uwv::model {
namespace {

constexpr int samples_per_side = 64;

struct Sample {
  Eigen::Vector2d xy, uv;
  double z;
};

/// Points on a coarse grid, in units of their own size, so that the steps below suit any scale.
std::vector<Sample> sampled(const VectorMap& points, const FloatMap& known, Size frame, double& unit) {
  const int columns = std::min(samples_per_side, points.width()), rows = std::min(samples_per_side, points.height());
  std::vector<Sample> samples;
  unit = 0;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const int x = static_cast<int>((i + 0.5) * points.width() / columns);
      const int y = static_cast<int>((j + 0.5) * points.height() / rows);
      if (!(known(x, y) > 0)) continue;
      const Eigen::Vector3d point = points(x, y).cast<double>();
      const Eigen::Vector2d uv(((x + 0.5) / points.width() - 0.5) * frame.width,
                               ((y + 0.5) / points.height() - 0.5) * frame.height);
      samples.push_back({point.head<2>(), uv, point.z()});
      unit = std::max(unit, point.cwiseAbs().maxCoeff());
    }
  }
  for (Sample& sample : samples) {
    sample.xy /= unit;
    sample.z /= unit;
  }
  return samples;
}

/// The fit for one shift: the best focal, the cost, and the cost's slope and curvature (Gauss-Newton's) in the shift.
struct Fit {
  double focal = 0;
  double cost = std::numeric_limits<double>::infinity();
  double slope = 0, curvature = 0;
};

Fit fit(const std::vector<Sample>& samples, double shift) {
  double top = 0, bottom = 0, top_slope = 0, bottom_slope = 0;
  for (const Sample& s : samples) {
    const double depth = s.z + shift;
    if (!(depth > 0)) return {};
    const Eigen::Vector2d p = s.xy / depth, p_slope = -p / depth;
    top += p.dot(s.uv);
    bottom += p.squaredNorm();
    top_slope += p_slope.dot(s.uv);
    bottom_slope += 2 * p.dot(p_slope);
  }
  if (!(bottom > 0) || !(top > 0)) return {};
  Fit result;
  result.focal = top / bottom;
  result.cost = 0;
  const double focal_slope = (top_slope - result.focal * bottom_slope) / bottom;
  for (const Sample& s : samples) {
    const Eigen::Vector2d p = s.xy / (s.z + shift), p_slope = -p / (s.z + shift);
    const Eigen::Vector2d rest = result.focal * p - s.uv, rest_slope = focal_slope * p + result.focal * p_slope;
    result.cost += rest.squaredNorm();
    result.slope += rest.dot(rest_slope);
    result.curvature += rest_slope.squaredNorm();
  }
  return result;
}

/// A start in the right basin: 0 where it is allowed, and shifts that put the nearest point at various distances.
double first_guess(const std::vector<Sample>& samples) {
  double nearest = std::numeric_limits<double>::infinity(), farthest = -nearest;
  for (const Sample& s : samples) {
    nearest = std::min(nearest, s.z);
    farthest = std::max(farthest, s.z);
  }
  const double range = std::max(farthest - nearest, 1e-6);
  double best = -nearest + range, best_cost = fit(samples, best).cost;
  const auto try_shift = [&](double shift) {
    const double cost = fit(samples, shift).cost;
    if (!(cost < best_cost)) return;
    best_cost = cost;
    best = shift;
  };
  try_shift(0);
  for (int i = -12; i <= 12; ++i) try_shift(-nearest + range * std::pow(10.0, i / 4.0));
  return best;
}

}  // namespace

FocalShift recover_focal_shift(const VectorMap& points, const FloatMap& known, Size frame) {
  double unit = 0;
  const std::vector<Sample> samples = sampled(points, known, frame, unit);
  if (samples.size() < 8 || !(unit > 0)) return {};
  double shift = first_guess(samples), damping = 1e-6;
  Fit now = fit(samples, shift);
  if (!std::isfinite(now.cost)) return {};
  double uv_energy = 0;
  for (const Sample& s : samples) uv_energy += s.uv.squaredNorm();

  FocalShift result;
  // The curvature is dimensionless here but for uv's: points at one depth leave it at rounding noise.
  result.shift_known = now.curvature > 1e-10 * uv_energy;
  if (!result.shift_known) {
    const Fit plain = fit(samples, 0);
    if (std::isfinite(plain.cost)) {
      shift = 0;
      now = plain;
    }
  }
  for (int i = 0; result.shift_known && i < 200; ++i) {
    const double step = -now.slope / (now.curvature * (1 + damping));
    const Fit next = fit(samples, shift + step);
    if (next.cost < now.cost) {
      shift += step;
      now = next;
      damping = std::max(damping / 10, 1e-12);
    } else {
      damping = damping < 1e-3 ? 1e-3 : damping * 10;
    }
    if (std::abs(step) < 1e-12 || damping > 1e12) break;
  }
  result.focal = now.focal;
  result.shift = shift * unit;
  result.residual = std::sqrt(now.cost / static_cast<double>(samples.size()));
  return result;
}

}  // namespace uwv::model
