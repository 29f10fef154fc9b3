// SPDX-License-Identifier: Apache-2.0
#include "geometry/sfm/two_view.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <random>

namespace uwv::sfm {
namespace {

constexpr std::size_t min_inliers = 20;
constexpr double confidence = 0.9999;

Eigen::Vector3d ray(const Intrinsics& k, const Eigen::Vector2d& pixel) { return unproject(k, pixel, 1).normalized(); }

/// The rotation that turns the rays `a` into `b` best (Kabsch).
Eigen::Matrix3d turn(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b,
                     const std::vector<std::size_t>& of) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const std::size_t i : of) sum += b[i] * a[i].transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

std::vector<double> turning_residuals(const std::vector<Pair>& pairs, const std::vector<Eigen::Vector3d>& rays_a,
                                      const Eigen::Matrix3d& b_from_a, const Intrinsics& k) {
  std::vector<double> residuals(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    Eigen::Vector2d landed(0, 0);
    residuals[i] = project(k, b_from_a * rays_a[i], landed) ? (landed - pairs[i].b).norm() : 1e9;
  }
  return residuals;
}

}  // namespace

RotationFit fit_rotation(const std::vector<Pair>& pairs, const Intrinsics& k, std::uint64_t seed) {
  RotationFit best;
  best.residual_px = 1e9;
  if (pairs.size() < 3) return best.residual_px = 0, best;
  std::vector<Eigen::Vector3d> a, b;
  for (const Pair& pair : pairs) a.push_back(ray(k, pair.a)), b.push_back(ray(k, pair.b));
  std::mt19937_64 random(seed);
  constexpr int trials = 60;  // half the points moving by themselves still leaves a good pair with certainty
  for (int trial = 0; trial < trials; ++trial) {
    const std::size_t i = random() % pairs.size(), j = random() % pairs.size();
    if (i == j) continue;
    const Eigen::Matrix3d guess = turn(a, b, {i, j});
    const double residual = median(turning_residuals(pairs, a, guess, k));
    if (residual < best.residual_px) best = {guess, residual};
  }
  for (int refinement = 0; refinement < 3; ++refinement) {
    const std::vector<double> residuals = turning_residuals(pairs, a, best.b_from_a, k);
    std::vector<std::size_t> near;
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (residuals[i] <= std::max(1.0, 2 * best.residual_px)) near.push_back(i);
    if (near.size() < 3) break;
    const Eigen::Matrix3d refined = turn(a, b, near);
    const double residual = median(turning_residuals(pairs, a, refined, k));
    if (residual >= best.residual_px) break;
    best = {refined, residual};
  }
  return best;
}

std::optional<RelativePose> relative_pose(const std::vector<Pair>& pairs, const Intrinsics& k, double max_error_px) {
  if (pairs.size() < min_inliers) return std::nullopt;
  std::vector<cv::Point2d> a, b;
  for (const Pair& pair : pairs) {
    a.emplace_back((pair.a.x() - k.cx) / k.fx, (pair.a.y() - k.cy) / k.fy);
    b.emplace_back((pair.b.x() - k.cx) / k.fx, (pair.b.y() - k.cy) / k.fy);
  }
  const double threshold = max_error_px / std::sqrt(std::abs(k.fx * k.fy));
  cv::Mat mask, rotation, translation;
  const cv::Mat identity = cv::Mat::eye(3, 3, CV_64F);
  cv::Mat essential = cv::findEssentialMat(a, b, identity, cv::RANSAC, confidence, threshold, 1000, mask);
  if (essential.rows != 3) return std::nullopt;
  constexpr double farthest = 1e4;  // baselines; the default of 50 throws away the scene of a small step
  cv::Mat points;
  cv::recoverPose(essential, a, b, identity, rotation, translation, farthest, mask, points);
  RelativePose pose;
  cv::cv2eigen(rotation, pose.b_from_a.rotation);
  Eigen::Vector3d direction;
  cv::cv2eigen(translation, direction);
  pose.b_from_a.translation = direction.normalized();
  std::vector<double> angles;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (mask.at<unsigned char>(static_cast<int>(i)) == 0) continue;
    pose.inliers.push_back(i);
    const Eigen::Vector3d from_b = pose.b_from_a.rotation.transpose() * ray(k, pairs[i].b);
    angles.push_back(std::acos(std::clamp(from_b.dot(ray(k, pairs[i].a)), -1.0, 1.0)));
  }
  pose.median_angle = median(std::move(angles));
  if (pose.inliers.size() < min_inliers) return std::nullopt;
  return pose;
}

std::optional<Eigen::Vector3d> triangulate(const std::vector<Rigid3>& cams_from_world,
                                           const std::vector<Eigen::Vector2d>& pixels, const Intrinsics& k) {
  // Homogeneous, so that far points are no harder than near ones.
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const double x = (pixels[i].x() - k.cx) / k.fx, y = (pixels[i].y() - k.cy) / k.fy;
    Eigen::Matrix<double, 3, 4> m;
    m << cams_from_world[i].rotation, cams_from_world[i].translation;
    const Eigen::Vector4d first = x * m.row(2) - m.row(0), second = y * m.row(2) - m.row(1);
    normal += first * first.transpose() + second * second.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(normal);
  const Eigen::Vector4d h = solver.eigenvectors().col(0);
  if (std::abs(h[3]) < 1e-9 * h.head<3>().norm()) return std::nullopt;
  const Eigen::Vector3d x_in_world = h.head<3>() / h[3];
  for (const Rigid3& cam : cams_from_world)
    if ((cam * x_in_world).z() <= 0) return std::nullopt;
  return x_in_world;
}

}  // namespace uwv::sfm
