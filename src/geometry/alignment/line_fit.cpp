// SPDX-License-Identifier: Apache-2.0
#include "geometry/alignment/line_fit.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>

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

/// All samples as one block of residuals; for the plain square, where nothing tells them apart.
class AllSamples : public ceres::CostFunction {
 public:
  explicit AllSamples(const Samples& samples) : samples_(samples) {
    set_num_residuals(static_cast<int>(samples.size()));
    mutable_parameter_block_sizes()->assign(2, 1);
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      const double root = std::sqrt(samples_[i].weight);
      residuals[i] = root * (parameters[0][0] * samples_[i].x + parameters[1][0] - samples_[i].y);
      if (jacobians == nullptr) continue;
      if (jacobians[0] != nullptr) jacobians[0][i] = root * samples_[i].x;
      if (jacobians[1] != nullptr) jacobians[1][i] = root;
    }
    return true;
  }

 private:
  const Samples& samples_;
};

/// One sample, so that a loss can bend its residual alone.
class OneSample : public ceres::SizedCostFunction<1, 1, 1> {
 public:
  explicit OneSample(const Sample& s) : x_(s.x), y_(s.y), root_(std::sqrt(s.weight)) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    residuals[0] = root_ * (parameters[0][0] * x_ + parameters[1][0] - y_);
    if (jacobians == nullptr) return true;
    if (jacobians[0] != nullptr) jacobians[0][0] = root_ * x_;
    if (jacobians[1] != nullptr) jacobians[1][0] = root_;
    return true;
  }

 private:
  double x_, y_, root_;
};

ceres::Problem::Options borrowing() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;
  return options;
}

ceres::Solver::Options exact() {
  ceres::Solver::Options options;
  // Normal equations would do, the problem being well conditioned; QR costs as little with two unknowns.
  options.linear_solver_type = ceres::DENSE_QR;
  options.initial_trust_region_radius = 1e16;  // the first step solves a plain square
  options.function_tolerance = 1e-15;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-13;
  options.max_num_iterations = 50;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  return options;
}

}  // namespace

double robust_weight(const Loss& loss, double residual) {
  const double relative = std::fabs(residual) / loss.scale;
  switch (loss.kind) {
    case AlignmentLoss::squared:
      return 1;
    case AlignmentLoss::huber:
      return relative <= 1 ? 1 : 1 / relative;
    case AlignmentLoss::cauchy:
      return 1 / (1 + relative * relative);
  }
  return 1;
}

bool fit_line(const Samples& samples, const Moments& moments, const Loss& loss, bool shift, AlignmentLine& line) {
  const Normalised to(moments, shift);
  Samples normalised(samples.size());
  std::transform(samples.begin(), samples.end(), normalised.begin(), [&](const Sample& s) { return to.of(s); });
  const AlignmentLine start = to.of(line);
  double a = start.scale, b = shift ? start.shift : 0;

  std::unique_ptr<ceres::CostFunction> together;
  std::unique_ptr<ceres::LossFunction> bend;
  std::deque<OneSample> single;  // cost functions cannot move
  ceres::Problem problem(borrowing());
  if (loss.kind == AlignmentLoss::squared) {
    together = std::make_unique<AllSamples>(normalised);
    problem.AddResidualBlock(together.get(), nullptr, &a, &b);
  } else {
    const double bend_at = loss.scale / to.scale_y;
    if (loss.kind == AlignmentLoss::huber)
      bend = std::make_unique<ceres::HuberLoss>(bend_at);
    else
      bend = std::make_unique<ceres::CauchyLoss>(bend_at);
    for (const Sample& s : normalised) {
      single.emplace_back(s);
      problem.AddResidualBlock(&single.back(), bend.get(), &a, &b);
    }
  }
  if (!shift) problem.SetParameterBlockConstant(&b);
  ceres::Solver::Summary summary;
  ceres::Solve(exact(), &problem, &summary);
  const AlignmentLine found = to.back(a, b);
  if (!summary.IsSolutionUsable() || !std::isfinite(found.scale) || !std::isfinite(found.shift)) return false;
  line = shift ? found : AlignmentLine{found.scale, 0};
  return true;
}

}  // namespace uwv::alignment
