// SPDX-License-Identifier: Apache-2.0
#include "geometry/sfm/bundle_adjustment.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <memory>

#include "geometry/hold_constant.h"

namespace uwv::sfm {
namespace {

constexpr std::size_t dense_cameras = 100;  // up to which the dense solver is as fast, or nearly

using Block = std::array<double, 6>;  // camera: angle-axis and translation of cam_from_world

/// What all observations of one camera share, worked out once per step of the solver.
struct CameraTerms {
  Eigen::Matrix3d rotation;
  Eigen::Matrix3d turn_by_axis;  // d(small rotation on the left) / d(angle-axis)

  void update(const Block& block) {
    const Eigen::Vector3d turn(block[0], block[1], block[2]);
    const double angle = turn.norm();
    ceres::AngleAxisToRotationMatrix(block.data(), rotation.data());
    const Eigen::Matrix3d across = cross(turn);
    // Left Jacobian of SO(3); its series near zero, where the quotients lose their digits.
    const double square = angle * angle;
    const double a = angle > 1e-4 ? (1 - std::cos(angle)) / square : 0.5 - square / 24;
    const double b = angle > 1e-4 ? (angle - std::sin(angle)) / (square * angle) : 1.0 / 6 - square / 120;
    turn_by_axis = Eigen::Matrix3d::Identity() + a * across + b * across * across;
  }

  static Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
    Eigen::Matrix3d out;
    out << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
    return out;
  }
};

/// The cameras of one adjustment and their zoom, a factor on the lens's fx and fy given by its logarithm.
struct Terms : ceres::EvaluationCallback {
  Intrinsics lens;
  double zoom = 1;
  std::vector<CameraTerms> cameras;
  std::vector<Block> blocks;  // one per camera, then the zoom's: the solver orders them by address

  double* log_zoom() { return blocks.back().data(); }

  void PrepareForEvaluation(bool, bool moved) override {
    if (!moved) return;
    zoom = std::exp(*log_zoom());
    for (std::size_t i = 0; i < cameras.size(); ++i) cameras[i].update(blocks[i]);
  }
};

/// Blocks: camera, point, log of the zoom. Derivatives by hand: automatic ones take most of an adjustment's time.
class Reprojection : public ceres::SizedCostFunction<2, 6, 3, 1> {
 public:
  Reprojection(const Terms& terms, const CameraTerms& camera, const Eigen::Vector2d& pixel)
      : terms_(terms), camera_(camera), pixel_(pixel) {}

  bool Evaluate(double const* const* blocks, double* residual, double** jacobians) const override {
    const Eigen::Map<const Eigen::Vector3d> x(blocks[1]);
    const Eigen::Vector3d turned = camera_.rotation * x;
    const Eigen::Vector3d p = turned + Eigen::Vector3d(blocks[0][3], blocks[0][4], blocks[0][5]);
    if (!(p.z() > 1e-9)) return false;
    const double fx = terms_.zoom * terms_.lens.fx, fy = terms_.zoom * terms_.lens.fy;
    const double u = p.x() / p.z(), v = p.y() / p.z();
    residual[0] = fx * u + terms_.lens.cx - pixel_.x();
    residual[1] = fy * v + terms_.lens.cy - pixel_.y();
    if (jacobians == nullptr) return true;
    Eigen::Matrix<double, 2, 3> by_p;
    by_p << fx / p.z(), 0, -fx * u / p.z(), 0, fy / p.z(), -fy * v / p.z();
    if (jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, 6, Eigen::RowMajor>> out(jacobians[0]);
      Eigen::Matrix<double, 2, 3> by_turn;
      for (int r = 0; r < 2; ++r) by_turn.row(r) = turned.cross(by_p.row(r).transpose()).transpose();
      out.leftCols<3>().noalias() = by_turn * camera_.turn_by_axis;
      out.rightCols<3>() = by_p;
    }
    if (jacobians[1] != nullptr)
      Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>>(jacobians[1]).noalias() = by_p * camera_.rotation;
    if (jacobians[2] != nullptr) {
      jacobians[2][0] = fx * u;
      jacobians[2][1] = fy * v;
    }
    return true;
  }

 private:
  const Terms& terms_;
  const CameraTerms& camera_;
  Eigen::Vector2d pixel_;
};

/// Keeps a focal length that nothing else determines near the expected one.
class FocalPrior : public ceres::SizedCostFunction<1, 1> {
 public:
  explicit FocalPrior(double log_expected) : log_expected_(log_expected) {}

  bool Evaluate(double const* const* blocks, double* residual, double** jacobians) const override {
    residual[0] = (blocks[0][0] - log_expected_) / spread;
    if (jacobians != nullptr && jacobians[0] != nullptr) jacobians[0][0] = 1 / spread;
    return true;
  }

 private:
  static constexpr double spread = 0.5;
  double log_expected_;
};

Block block_of(const Rigid3& pose) {
  Block out{};
  ceres::RotationMatrixToAngleAxis(pose.rotation.data(), out.data());
  for (int i = 0; i < 3; ++i) out[static_cast<std::size_t>(3 + i)] = pose.translation[i];
  return out;
}

Rigid3 pose_of(const Block& block) {
  Rigid3 out;
  ceres::AngleAxisToRotationMatrix(block.data(), out.rotation.data());
  out.translation = {block[3], block[4], block[5]};
  return out;
}

/// One adjustment: the problem owns nothing, so that its parts are made in few pieces of memory.
class Adjustment {
 public:
  /// The cameras' blocks are where `cameras` says and stay there.
  Adjustment(const Intrinsics& lens, std::size_t cameras, double loss_px)
      : loss_(loss_px), problem_(options_of(terms_)) {
    terms_.lens = lens;
    terms_.cameras.resize(cameras);
    terms_.blocks.assign(cameras + 1, Block{});
  }

  double* block(std::size_t camera) { return terms_.blocks[camera].data(); }
  double* log_zoom() { return terms_.log_zoom(); }
  ceres::Problem& problem() { return problem_; }
  void set_pose(std::size_t camera, const Rigid3& pose) { terms_.blocks[camera] = block_of(pose); }
  Rigid3 pose(std::size_t camera) const { return pose_of(terms_.blocks[camera]); }
  double zoom() const { return std::exp(terms_.blocks.back()[0]); }
  int observations() const { return static_cast<int>(costs_.size()); }

  void observe(std::size_t camera, double* point, const Eigen::Vector2d& pixel) {
    costs_.emplace_back(terms_, terms_.cameras[camera], pixel);
    problem_.AddResidualBlock(&costs_.back(), &loss_, block(camera), point, log_zoom());
  }
  void move_point(double* point, bool moves) {
    if (!moves) problem_.SetParameterBlockConstant(point);
    points_.push_back(point);
  }
  void expect_focal(double focal) {
    prior_.emplace(std::log(focal / terms_.lens.fx));
    problem_.AddResidualBlock(&*prior_, nullptr, log_zoom());
  }

  /// Root mean square error of the observations.
  double solve(int iterations, double tolerance) {
    ceres::Solver::Options options;
    // The sparse solver prints a warning to stderr whenever rounding costs it a step; few cameras do without it.
    options.linear_solver_type = terms_.cameras.size() <= dense_cameras ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
    options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (double* point : points_) options.linear_solver_ordering->AddElementToGroup(point, 0);
    for (Block& block : terms_.blocks)
      if (problem_.HasParameterBlock(block.data())) options.linear_solver_ordering->AddElementToGroup(block.data(), 1);
    options.max_num_iterations = iterations;
    options.function_tolerance = tolerance;
    // The free scale has no curvature of its own: what damping leaves it with must stay above rounding.
    options.max_trust_region_radius = 1e8;
    options.num_threads = 1;  // sums of several threads would depend on their number
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    return std::sqrt(2 * summary.final_cost / observations());
  }

 private:
  static ceres::Problem::Options options_of(Terms& terms) {
    ceres::Problem::Options options;
    options.cost_function_ownership = options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.evaluation_callback = &terms;
    options.disable_all_safety_checks = true;
    return options;
  }

  Terms terms_;
  std::deque<Reprojection> costs_;
  std::optional<FocalPrior> prior_;
  std::vector<double*> points_;
  ceres::CauchyLoss loss_;
  ceres::Problem problem_;
};

}  // namespace

double Reconstruction::error(const Track& track, std::size_t index, int frame) const {
  const auto& pose = cam_from_world[static_cast<std::size_t>(frame)];
  if (!pose || !points[index]) return std::numeric_limits<double>::infinity();
  return error_from(*pose, track, index, frame);
}

double Reconstruction::error_from(const Rigid3& pose, const Track& track, std::size_t index, int frame) const {
  Eigen::Vector2d pixel;
  if (!project(lens, pose * *points[index], pixel)) return std::numeric_limits<double>::infinity();
  return (pixel - track.at(frame)).norm();
}

std::vector<int> Reconstruction::registered() const {
  std::vector<int> out;
  for (std::size_t i = 0; i < cam_from_world.size(); ++i)
    if (cam_from_world[i]) out.push_back(static_cast<int>(i));
  return out;
}

double adjust(Reconstruction& reconstruction, const std::vector<Track>& tracks, const AdjustOptions& options) {
  const std::vector<int> frames = reconstruction.registered();
  if (frames.empty()) return 0;
  Adjustment adjustment(reconstruction.lens, frames.size(), options.loss_px);
  std::vector<std::size_t> camera_of(reconstruction.cam_from_world.size(), 0);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    camera_of[static_cast<std::size_t>(frames[i])] = i;
    adjustment.set_pose(i, *reconstruction.cam_from_world[static_cast<std::size_t>(frames[i])]);
  }
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    if (!reconstruction.points[t]) continue;
    std::vector<int> seen;
    for (int f = tracks[t].first; f < tracks[t].end(); ++f)
      if (reconstruction.error(tracks[t], t, f) < options.gate_px) seen.push_back(f);
    if (seen.size() < 2) continue;
    double* point = reconstruction.points[t]->data();
    for (const int f : seen) adjustment.observe(camera_of[static_cast<std::size_t>(f)], point, tracks[t].at(f));
    adjustment.move_point(point, options.move_points);
  }
  if (adjustment.observations() == 0) return 0;
  ceres::Problem& problem = adjustment.problem();
  if (problem.HasParameterBlock(adjustment.block(0))) problem.SetParameterBlockConstant(adjustment.block(0));
  for (std::size_t i = 1; i < frames.size() && options.fix_translation; ++i)
    if (problem.HasParameterBlock(adjustment.block(i))) hold_constant(problem, adjustment.block(i), 6, {3, 4, 5});
  if (options.refine_focal)
    adjustment.expect_focal(options.focal_prior);
  else
    problem.SetParameterBlockConstant(adjustment.log_zoom());
  const double rms = adjustment.solve(options.iterations, options.tolerance);
  for (std::size_t i = 0; i < frames.size(); ++i)
    reconstruction.cam_from_world[static_cast<std::size_t>(frames[i])] = adjustment.pose(i);
  reconstruction.lens.fx *= adjustment.zoom();
  reconstruction.lens.fy *= adjustment.zoom();
  return rms;
}

Rigid3 adjusted_camera(const Reconstruction& reconstruction, const std::vector<Track>& tracks,
                       std::span<const std::size_t> seen, int frame, const Rigid3& pose, double gate_px) {
  Adjustment adjustment(reconstruction.lens, 1, AdjustOptions{}.loss_px);
  adjustment.set_pose(0, pose);
  std::vector<Eigen::Vector3d> points;  // the solver wants to write where it holds still
  points.reserve(seen.size());
  for (const std::size_t t : seen) {
    if (!(reconstruction.error_from(pose, tracks[t], t, frame) < gate_px)) continue;
    points.push_back(*reconstruction.points[t]);
    adjustment.observe(0, points.back().data(), tracks[t].at(frame));
    adjustment.move_point(points.back().data(), false);
  }
  if (adjustment.observations() < 6) return pose;
  adjustment.problem().SetParameterBlockConstant(adjustment.log_zoom());
  adjustment.solve(10, 1e-5);
  return adjustment.pose(0);
}

}  // namespace uwv::sfm
