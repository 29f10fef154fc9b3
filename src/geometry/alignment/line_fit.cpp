// SPDX-License-Identifier: Apache-2.0
#include "geometry/alignment/line_fit.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace uwv::alignment {
namespace {

/// x and y moved and scaled so that both unknowns are of the order of one and do not depend on each other: the solver
/// then meets the same problem whatever the magnitudes were.
struct Normalised {
  double centre_x = 0, centre_y = 0, scale_x = 1, scale_y = 1;

  Normalised(const Moments& m, bool shift) {
    if (shift) {
      centre_x = m.mean_x;
      centre_y = m.mean_y;
      scale_x = std::sqrt(m.xx);
      scale_y = std::sqrt(m.yy);
    } else {
      scale_x = std::hypot(m.mean_x, std::sqrt(m.xx));
      scale_y = std::hypot(m.mean_y, std::sqrt(m.yy));
    }
  }
  Sample of(const Sample& s) const { return {(s.x - centre_x) / scale_x, (s.y - centre_y) / scale_y, s.weight}; }
  AlignmentLine of(const AlignmentLine& line) const {
    return {line.scale * scale_x / scale_y, (line.shift + line.scale * centre_x - centre_y) / scale_y};
  }
  AlignmentLine back(double scale, double shift) const {
    const double a = scale * scale_y / scale_x;
    return {a, centre_y + scale_y * shift - a * centre_x};
  }
};

/// A residual r as the solver squares it: its square is rho(r), and its derivative by r.
struct Bent {
  double value = 0, slope = 1;
};

/// `bend` is where the loss bends; huber: rho = r^2 up to there and 2 bend |r| - bend^2 beyond, cauchy:
/// bend^2 ln(1 + (r / bend)^2).
Bent bent(AlignmentLoss kind, double bend, double r) {
  const double size = std::fabs(r);
  if (kind == AlignmentLoss::squared || (kind == AlignmentLoss::huber && size <= bend)) return {r, 1};
  if (kind == AlignmentLoss::huber) {
    const double root = std::sqrt(2 * bend * size - bend * bend);
    return {std::copysign(root, r), bend / root};
  }
  const double relative = r / bend, root = bend * std::sqrt(std::log1p(relative * relative));
  // Near 0 root / size tends to 1, and so does the slope.
  return {std::copysign(root, r), size < 1e-6 * bend ? 1 : size / (root * (1 + relative * relative))};
}

/// All samples as one block of residuals with the loss inside: the solver's own losses want a block a sample, which
/// for a whole picture costs ten times as much.
class AllSamples : public ceres::CostFunction {
 public:
  /// `units`: what the loss counts each sample's residual in.
  AllSamples(const Samples& samples, std::vector<double> units, const Loss& loss)
      : samples_(samples), units_(std::move(units)), loss_(loss) {
    set_num_residuals(static_cast<int>(samples.size()));
    mutable_parameter_block_sizes()->assign(2, 1);
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    double* by_scale = jacobians == nullptr ? nullptr : jacobians[0];
    double* by_shift = jacobians == nullptr ? nullptr : jacobians[1];
    const AlignmentLine line{parameters[0][0], parameters[1][0]};
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      const double root = std::sqrt(samples_[i].weight);
      const Bent here = bent(loss_.kind, loss_.scale, residual(line, samples_[i]) / units_[i]);
      const double slope = root * here.slope / units_[i];
      residuals[i] = root * here.value;
      if (by_scale != nullptr) by_scale[i] = slope * samples_[i].x;
      if (by_shift != nullptr) by_shift[i] = slope;
    }
    return true;
  }

 private:
  const Samples& samples_;
  std::vector<double> units_;
  Loss loss_;
};

ceres::Problem::Options borrowing() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;
  return options;
}

ceres::Solver::Options precise(AlignmentLoss kind) {
  ceres::Solver::Options options;
  // Normal equations would do, the problem being well conditioned; QR costs as little with two unknowns.
  options.linear_solver_type = ceres::DENSE_QR;
  options.initial_trust_region_radius = 1e16;  // the first step solves a plain square
  // A plain square is solved to the last digit at no cost. A bent one converges slowly; its samples are chosen anew
  // after each solution, and a millionth of their spread is far below their noise.
  const bool plain = kind == AlignmentLoss::squared;
  options.function_tolerance = plain ? 1e-15 : 1e-9;
  options.gradient_tolerance = plain ? 1e-14 : 1e-9;
  options.parameter_tolerance = plain ? 1e-13 : 1e-6;
  options.max_num_iterations = 30;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  return options;
}

}  // namespace

double robust_weight(const Loss& loss, double relative_residual) {
  const double relative = std::fabs(relative_residual) / loss.scale;
  switch (loss.kind) {
    case AlignmentLoss::squared: return 1;
    case AlignmentLoss::huber: return relative <= 1 ? 1 : 1 / relative;
    case AlignmentLoss::cauchy: return 1 / (1 + relative * relative);
  }
  return 1;
}

bool fit_line(const Samples& samples, const Moments& moments, const Loss& loss, bool shift, AlignmentLine& line) {
  const Normalised to(moments, shift);
  Samples normalised(samples.size());
  std::transform(samples.begin(), samples.end(), normalised.begin(), [&](const Sample& s) { return to.of(s); });
  const AlignmentLine start = to.of(line);
  double a = start.scale, b = shift ? start.shift : 0;

  std::vector<double> units(samples.size(), 1.0);
  if (loss.kind != AlignmentLoss::squared)
    std::transform(samples.begin(), samples.end(), units.begin(),
                   [&](const Sample& s) { return s.unit() / to.scale_y; });
  AllSamples cost(normalised, std::move(units), loss);
  ceres::Problem problem(borrowing());
  problem.AddResidualBlock(&cost, nullptr, &a, &b);
  if (!shift) problem.SetParameterBlockConstant(&b);
  ceres::Solver::Summary summary;
  ceres::Solve(precise(loss.kind), &problem, &summary);
  const AlignmentLine found = to.back(a, b);
  if (!summary.IsSolutionUsable() || !std::isfinite(found.scale) || !std::isfinite(found.shift)) return false;
  line = shift ? found : AlignmentLine{found.scale, 0};
  return true;
}

}  // namespace uwv::alignment
