// SPDX-License-Identifier: Apache-2.0
#include "geometry/alignment/joint.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/hold_constant.h"

namespace uwv::alignment {
namespace {

using Line2 = std::array<double, 2>;

/// A frame's mean squared residual, short of a constant: how far the line misses the mean point, and how far its slope
/// misses the samples'. Exact, since squares of a line depend on samples through their moments only.
class FrameCost : public ceres::SizedCostFunction<2, 2> {
 public:
  FrameCost(const Moments& m, double share) : m_(m), root_(std::sqrt(share)), spread_(std::sqrt(m.xx)) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const double* line = parameters[0];
    residuals[0] = root_ * (line[0] * m_.mean_x + line[1] - m_.mean_y);
    residuals[1] = spread_ > 0 ? root_ * (line[0] * spread_ - m_.xy / spread_) : 0;
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    jacobians[0][0] = root_ * m_.mean_x;
    jacobians[0][1] = root_;
    jacobians[0][2] = root_ * spread_;
    jacobians[0][3] = 0;
    return true;
  }

 private:
  Moments m_;
  double root_, spread_;
};

/// Share of `smooth_frames` within which lines would fade if change as such were all that had a price. Small: steady
/// drift stays nearly free; not zero: beyond the last frame with samples lines level out instead of running away.
constexpr double levelling = 0.2;

/// The price of change from one frame to the next.
class ChangeCost : public ceres::SizedCostFunction<2, 2, 2> {
 public:
  explicit ChangeCost(double root) : root_(root) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    for (int i = 0; i < 2; ++i) residuals[i] = root_ * (parameters[1][i] - parameters[0][i]);
    if (jacobians == nullptr) return true;
    for (int block = 0; block < 2; ++block) {
      if (jacobians[block] == nullptr) continue;
      const double sign = block == 0 ? -root_ : root_;
      jacobians[block][0] = jacobians[block][3] = sign;
      jacobians[block][1] = jacobians[block][2] = 0;
    }
    return true;
  }

 private:
  double root_;
};

/// Moments of all frames' samples together, each frame counting by its share.
Moments pooled(const std::vector<FrameFit>& fits, const std::vector<double>& shares) {
  Moments all;
  for (std::size_t i = 0; i < fits.size(); ++i) {
    all.weight += shares[i];
    all.mean_x += shares[i] * fits[i].moments.mean_x;
    all.mean_y += shares[i] * fits[i].moments.mean_y;
  }
  if (!(all.weight > 0)) return {};
  all.mean_x /= all.weight;
  all.mean_y /= all.weight;
  for (std::size_t i = 0; i < fits.size(); ++i) {
    const Moments& m = fits[i].moments;
    const double dx = m.mean_x - all.mean_x, dy = m.mean_y - all.mean_y, w = shares[i] / all.weight;
    all.xx += w * (m.xx + dx * dx);
    all.xy += w * (m.xy + dx * dy);
    all.yy += w * (m.yy + dy * dy);
  }
  return all;
}

std::vector<double> shares_of(const std::vector<FrameFit>& fits) {
  std::vector<double> counts;
  for (const FrameFit& fit : fits)
    if (fit.moments.weight > 0) counts.push_back(static_cast<double>(fit.report.inliers));
  std::vector<double> shares(fits.size(), 0.0);
  if (counts.empty()) return shares;
  const auto middle = counts.begin() + static_cast<std::ptrdiff_t>(counts.size() / 2);
  std::nth_element(counts.begin(), middle, counts.end());
  for (std::size_t i = 0; i < fits.size(); ++i)
    if (fits[i].moments.weight > 0) shares[i] = std::min(1.0, static_cast<double>(fits[i].report.inliers) / *middle);
  return shares;
}

/// The units the joint problem is solved in: the clip's samples have mean 0 and deviation 1 there (a model without a
/// shift keeps its origin).
struct Units {
  double centre_x = 0, centre_y = 0, scale_x = 1, scale_y = 1;
  Units(const Moments& m, bool shift) {
    if (shift) {
      centre_x = m.mean_x;
      centre_y = m.mean_y;
    }
    scale_x = std::sqrt(m.xx + std::pow(m.mean_x - centre_x, 2));
    scale_y = std::sqrt(m.yy + std::pow(m.mean_y - centre_y, 2));
  }
  Moments of(const Moments& m) const {
    return {m.weight,
            (m.mean_x - centre_x) / scale_x,
            (m.mean_y - centre_y) / scale_y,
            m.xx / (scale_x * scale_x),
            m.xy / scale_x / scale_y,
            m.yy / (scale_y * scale_y)};
  }
  AlignmentLine back(const Line2& line) const {
    const double a = line[0] * scale_y / scale_x;
    return {a, centre_y + scale_y * line[1] - a * centre_x};
  }
};

/// The price of a change that is not the one before.
class BendCost : public ceres::SizedCostFunction<2, 2, 2, 2> {
 public:
  explicit BendCost(double root) : root_(root) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    for (int i = 0; i < 2; ++i) residuals[i] = root_ * (parameters[0][i] - 2 * parameters[1][i] + parameters[2][i]);
    if (jacobians == nullptr) return true;
    for (int block = 0; block < 3; ++block) {
      if (jacobians[block] == nullptr) continue;
      jacobians[block][0] = jacobians[block][3] = block == 1 ? -2 * root_ : root_;
      jacobians[block][1] = jacobians[block][2] = 0;
    }
    return true;
  }

 private:
  double root_;
};

ceres::Solver::Options banded() {
  ceres::Solver::Options options;
  // Eigen's solver, where Ceres has it, does the same on every machine.
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  if (ceres::IsSparseLinearAlgebraLibraryTypeAvailable(ceres::EIGEN_SPARSE))
    options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  options.initial_trust_region_radius = 1e16;
  options.function_tolerance = 1e-15;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-13;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  return options;
}

}  // namespace

bool solve_jointly(const std::vector<FrameFit>& fits, const AlignmentOptions& options,
                   std::vector<AlignmentLine>& lines) {
  const bool shift = has_shift(options.model);
  const std::vector<double> shares = shares_of(fits);
  const Moments all = pooled(fits, shares);
  if (!(all.weight > 0) || is_singular(all, shift)) return false;
  const Units units(all, shift);

  std::vector<Line2> unknown(fits.size(), Line2{1, 0});
  ceres::Problem problem;
  for (std::size_t i = 0; i < fits.size(); ++i) {
    problem.AddParameterBlock(unknown[i].data(), 2);
    if (!shift) hold_constant(problem, unknown[i].data(), 2, {1});
    if (shares[i] > 0)
      problem.AddResidualBlock(new FrameCost(units.of(fits[i].moments), shares[i]), nullptr, unknown[i].data());
    if (i > 0)
      problem.AddResidualBlock(new ChangeCost(levelling * options.smooth_frames), nullptr, unknown[i - 1].data(),
                               unknown[i].data());
    if (i > 1)
      problem.AddResidualBlock(new BendCost(options.smooth_frames * options.smooth_frames), nullptr,
                               unknown[i - 2].data(), unknown[i - 1].data(), unknown[i].data());
  }
  ceres::Solver::Summary summary;
  ceres::Solve(banded(), &problem, &summary);
  if (!summary.IsSolutionUsable()) return false;
  lines.clear();
  for (const Line2& line : unknown) {
    const AlignmentLine back = units.back(line);
    if (!std::isfinite(back.scale) || !std::isfinite(back.shift)) return false;
    lines.push_back(shift ? back : AlignmentLine{back.scale, 0});
  }
  return true;
}

}  // namespace uwv::alignment
