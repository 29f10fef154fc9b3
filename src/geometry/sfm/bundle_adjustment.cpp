// SPDX-License-Identifier: Apache-2.0
#include "geometry/sfm/bundle_adjustment.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <array>

namespace uwv::sfm {
namespace {

using Pose = std::array<double, 6>;  // angle-axis, then translation: cam_from_world

/// Where a point lands minus where it was seen, pixels. Focal length: one factor on the intrinsics' own.
struct Landing {
  Eigen::Vector2d seen;
  Intrinsics k;

  template <class T>
  bool operator()(const T* pose, const T* point, const T* focal_factor, T* residual) const {
    T x[3];
    ceres::AngleAxisRotatePoint(pose, point, x);
    for (int i = 0; i < 3; ++i) x[i] += pose[3 + i];
    if (x[2] <= T(0)) return false;
    residual[0] = *focal_factor * k.fx * x[0] / x[2] + k.cx - seen.x();
    residual[1] = *focal_factor * k.fy * x[1] / x[2] + k.cy - seen.y();
    return true;
  }
};

struct FocalPrior {
  double expected_log;
  template <class T>
  bool operator()(const T* factor, T* residual) const {
    constexpr double weight = 5;  // a factor of two costs as much as a dozen pixels: only the undecided feel it
    if (*factor <= T(0)) return false;
    residual[0] = weight * (log(*factor) - expected_log);
    return true;
  }
};

Pose to_parameters(const Rigid3& pose) {
  Pose p{};
  const Eigen::AngleAxisd turn(pose.rotation);
  Eigen::Map<Eigen::Vector3d>(p.data()) = turn.angle() * turn.axis();
  Eigen::Map<Eigen::Vector3d>(p.data() + 3) = pose.translation;
  return p;
}

Rigid3 to_pose(const Pose& p) {
  const Eigen::Map<const Eigen::Vector3d> turn(p.data()), translation(p.data() + 3);
  const double angle = turn.norm();
  Rigid3 pose;
  if (angle > 0) pose.rotation = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
  pose.translation = translation;
  return pose;
}

}  // namespace

void adjust(const std::vector<Track>& tracks, const AdjustOptions& options, Model& model) {
  std::map<int, Pose> poses;
  for (const auto& [frame, pose] : model.cam_from_world) poses[frame] = to_parameters(pose);
  double focal_factor = 1;
  ceres::Problem problem;
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    if (model.known[t] == 0) continue;
    for (auto& [frame, pose] : poses) {
      if (!tracks[t].covers(frame) || reprojection_error(model, tracks[t], t, frame) < 0) continue;
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<Landing, 2, 6, 3, 1>(new Landing{tracks[t].at(frame), model.intrinsics}),
          new ceres::CauchyLoss(options.loss_px), pose.data(), model.points[t].data(), &focal_factor);
    }
  }
  if (problem.NumResidualBlocks() == 0) return;
  if (!options.focal)
    problem.SetParameterBlockConstant(&focal_factor);
  else if (options.prior_focal > 0)
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<FocalPrior, 1, 1>(
            new FocalPrior{std::log(options.prior_focal / std::abs(model.intrinsics.fx))}),
        nullptr, &focal_factor);
  if (Pose& first = poses.begin()->second; problem.HasParameterBlock(first.data()))
    problem.SetParameterBlockConstant(first.data());

  ceres::Solver::Options solver;
  solver.linear_solver_type = poses.size() < 60 ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
  solver.max_num_iterations = options.iterations;
  solver.num_threads = options.threads;
  solver.function_tolerance = 1e-5;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  if (!summary.IsSolutionUsable()) return;
  for (auto& [frame, pose] : model.cam_from_world) pose = to_pose(poses[frame]);
  model.intrinsics.fx *= focal_factor;
  model.intrinsics.fy *= focal_factor;
}

double reprojection_error(const Model& model, const Track& track, std::size_t index, int frame) {
  Eigen::Vector2d landed(0, 0);
  if (!project(model.intrinsics, model.cam_from_world.at(frame) * model.points[index], landed)) return -1;
  return (landed - track.at(frame)).norm();
}

}  // namespace uwv::sfm
