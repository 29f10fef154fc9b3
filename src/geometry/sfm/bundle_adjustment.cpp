// SPDX-License-Identifier: Apache-2.0
#include "geometry/sfm/bundle_adjustment.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "geometry/hold_constant.h"

namespace uwv::sfm {
namespace {

/// Camera: angle-axis and translation of cam_from_world. Focal: log of the factor on the lens's fx and fy.
struct Reprojection {
  Intrinsics lens;
  Eigen::Vector2d pixel;

  template <class T>
  bool operator()(const T* camera, const T* point, const T* log_zoom, T* residual) const {
    T p[3];
    ceres::AngleAxisRotatePoint(camera, point, p);
    for (int i = 0; i < 3; ++i) p[i] += camera[3 + i];
    if (!(p[2] > T(1e-9))) return false;
    using std::exp;
    const T zoom = exp(log_zoom[0]);
    residual[0] = zoom * lens.fx * p[0] / p[2] + lens.cx - pixel.x();
    residual[1] = zoom * lens.fy * p[1] / p[2] + lens.cy - pixel.y();
    return true;
  }
};

struct FocalPrior {
  double log_expected;
  template <class T>
  bool operator()(const T* log_zoom, T* residual) const {
    residual[0] = (log_zoom[0] - T(log_expected)) / T(0.5);
    return true;
  }
};

using Block = std::array<double, 6>;

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

ceres::CostFunction* reprojection(const Intrinsics& lens, const Eigen::Vector2d& pixel) {
  return new ceres::AutoDiffCostFunction<Reprojection, 2, 6, 3, 1>(new Reprojection{lens, pixel});
}

double solve(ceres::Problem& problem, ceres::LinearSolverType solver, int iterations, int residuals) {
  ceres::Solver::Options options;
  options.linear_solver_type = solver;
  options.max_num_iterations = iterations;
  options.function_tolerance = 1e-5;
  options.num_threads = 1;  // sums of several threads would depend on their number
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return residuals > 0 ? std::sqrt(2 * summary.final_cost / residuals) : 0;
}

}  // namespace

double Reconstruction::error(const Track& track, std::size_t index, int frame) const {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  const auto& pose = cam_from_world[static_cast<std::size_t>(frame)];
  if (!pose || !points[index]) return infinite;
  Eigen::Vector2d pixel;
  if (!project(lens, *pose * *points[index], pixel)) return infinite;
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
  std::map<int, Block> cameras;
  for (const int f : frames) cameras[f] = block_of(*reconstruction.cam_from_world[static_cast<std::size_t>(f)]);
  double log_zoom = 0;
  ceres::Problem problem;
  auto* loss = new ceres::CauchyLoss(1.0);
  int count = 0;
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    if (!reconstruction.points[t]) continue;
    std::vector<int> seen;
    for (int f = tracks[t].first; f < tracks[t].end(); ++f)
      if (reconstruction.error(tracks[t], t, f) < options.gate_px) seen.push_back(f);
    if (seen.size() < 2) continue;
    double* point = reconstruction.points[t]->data();
    for (const int f : seen)
      problem.AddResidualBlock(reprojection(reconstruction.lens, tracks[t].at(f)), loss, cameras[f].data(), point,
                               &log_zoom);
    if (!options.move_points) problem.SetParameterBlockConstant(point);
    count += static_cast<int>(seen.size());
  }
  if (count == 0) {
    delete loss;  // the problem owns it only once it is used
    return 0;
  }
  if (problem.HasParameterBlock(cameras.begin()->second.data()))
    problem.SetParameterBlockConstant(cameras.begin()->second.data());
  if (options.fix_translation)
    for (auto& [f, block] : cameras)
      if (f != frames.front() && problem.HasParameterBlock(block.data()))
        hold_constant(problem, block.data(), 6, {3, 4, 5});
  if (options.refine_focal) {
    const double expected = std::log(options.focal_prior / reconstruction.lens.fx);
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<FocalPrior, 1, 1>(new FocalPrior{expected}), nullptr,
                             &log_zoom);
    problem.SetParameterLowerBound(&log_zoom, 0, -0.7);
    problem.SetParameterUpperBound(&log_zoom, 0, 0.7);
  } else {
    problem.SetParameterBlockConstant(&log_zoom);
  }
  const double rms = solve(problem, ceres::SPARSE_SCHUR, options.iterations, count);
  for (const int f : frames) reconstruction.cam_from_world[static_cast<std::size_t>(f)] = pose_of(cameras[f]);
  reconstruction.lens.fx *= std::exp(log_zoom);
  reconstruction.lens.fy *= std::exp(log_zoom);
  return rms;
}

void adjust_camera(Reconstruction& reconstruction, const std::vector<Track>& tracks, int frame, double gate_px) {
  auto& pose = reconstruction.cam_from_world[static_cast<std::size_t>(frame)];
  Block camera = block_of(*pose);
  double log_zoom = 0;
  ceres::Problem problem;
  int count = 0;
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    if (!tracks[t].in(frame) || !(reconstruction.error(tracks[t], t, frame) < gate_px)) continue;
    double* point = reconstruction.points[t]->data();
    problem.AddResidualBlock(reprojection(reconstruction.lens, tracks[t].at(frame)), new ceres::CauchyLoss(1.0),
                             camera.data(), point, &log_zoom);
    problem.SetParameterBlockConstant(point);
    ++count;
  }
  if (count < 6) return;
  problem.SetParameterBlockConstant(&log_zoom);
  solve(problem, ceres::DENSE_QR, 10, count);
  pose = pose_of(camera);
}

}  // namespace uwv::sfm
