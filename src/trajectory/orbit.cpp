// SPDX-License-Identifier: Apache-2.0
#include "uwv/trajectory/orbit.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "trajectory/rotations.h"
#include "uwv/trajectory/smoothing_spline.h"

namespace uwv {
namespace {

using detail::radians;
using detail::rotation_x;
using detail::rotation_y;

void check_frames(long frames) {
  require(frames >= 1, "a path of {} frames was asked for; at least 1 is wanted", frames);
}

/// k / (n-1), the way numpy.linspace spreads n values over [0, 1]; 0 for a single one.
double spread(long k, long n) { return n > 1 ? static_cast<double>(k) / static_cast<double>(n - 1) : 0.0; }

/// Turned about the world's x, then its y axis.
Rigid3 turned(const Rigid3& pose, double theta_deg, double phi_deg) {
  const Eigen::Matrix3d turn = rotation_y(radians(phi_deg)) * rotation_x(radians(theta_deg));
  return {turn * pose.rotation, turn * pose.translation};
}

double interpolate_linearly(std::span<const double> keys, double u) {
  const double position = u * static_cast<double>(keys.size() - 1);
  const auto left = std::min(static_cast<std::size_t>(position), keys.size() - 2);
  const double share = position - static_cast<double>(left);
  return keys[left] + share * (keys[left + 1] - keys[left]);
}

std::vector<double> smoothed(std::span<const double> keys, long frames) {
  std::vector<double> positions(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) positions[i] = spread(static_cast<long>(i), std::ssize(keys));
  const CubicSpline spline = smoothing_spline(positions, keys);
  std::vector<double> values(static_cast<std::size_t>(frames));
  for (long k = 0; k < frames; ++k) values[static_cast<std::size_t>(k)] = spline(spread(k, frames));
  return values;
}

void check_list(const std::vector<double>& list, std::string_view name) {
  require(!list.empty(), "the list {} of a trajectory is empty; at least one value is wanted", name);
  for (const double value : list) require(std::isfinite(value), "the list {} of a trajectory holds {}", name, value);
}

}  // namespace

void FreeMove::check() const {
  for (const double value : {d_phi, d_theta, x, y, z})
    require(std::isfinite(value), "a free move holds the value {}", value);
  require(std::isfinite(d_r) && d_r > 0, "d_r is {}; a positive number is wanted", d_r);
  require(std::isfinite(focal) && focal > 0, "focal is {}; a positive number is wanted", focal);
}

void OrbitLists::check() const {
  check_list(phi, "phi");
  check_list(theta, "theta");
  check_list(r, "r");
  for (const double value : r)
    require(value > -1, "the list r of a trajectory holds {}; values > -1 are wanted", value);
}

CameraPath free_path(const FreeMove& move, const Rigid3& start, double offset_radius, long frames) {
  move.check();
  check_frames(frames);
  CameraPath path{{start}, {1.0}};
  const Eigen::Vector3d offset = offset_radius * Eigen::Vector3d(move.x, move.y, move.z);
  for (long k = 1; k < frames; ++k) {
    const double u = ease(move.easing, spread(k, frames));
    const double q = ease(move.easing, static_cast<double>(k) / static_cast<double>(frames));
    Rigid3 pose = turned(start, u * move.d_theta, u * move.d_phi);
    pose.translation += q * offset;
    pose.translation *= u * move.d_r + (1 - u);
    const double zoom = move.focal * q + (1 - q);
    path.subject_from_cam.push_back(pose);
    path.zoom.push_back(move.zoom_twice ? zoom * zoom : zoom);
  }
  return path;
}

std::vector<double> spread_keys(std::span<const double> keys, long frames) {
  require(!keys.empty(), "a list of keys is empty; at least one value is wanted");
  check_frames(frames);
  if (keys.size() == 1) return std::vector<double>(static_cast<std::size_t>(frames), keys[0]);
  if (keys.size() > 3) {
    std::vector<double> values = smoothed(keys, frames);
    values.back() = keys.back();
    values.front() = keys.front();
    return values;
  }
  std::vector<double> values(static_cast<std::size_t>(frames));
  for (long k = 0; k < frames; ++k) values[static_cast<std::size_t>(k)] = interpolate_linearly(keys, spread(k, frames));
  return values;
}

CameraPath swing_path(int which, double focal, const Rigid3& start, long frames) {
  require(which == 1 || which == 2, "there is no swing {}; 1 or 2 is wanted", which);
  check_frames(frames);
  static constexpr double phi1[] = {0, -5, -25, -30, -20, -8, 0};
  static constexpr double theta1[] = {0, -8, -12, -20, -17, -12, -5, -2, 1, 5, 3, 1, 0};
  static constexpr double r1[] = {0, 0.2};
  static constexpr double phi2[] = {0, 5, 25, 30, 20, 10, 0};
  static constexpr double theta2[] = {0, -5, -14, -11, 0, 1, 5, 3, 0};
  static constexpr double r2[] = {0, -0.03, -0.1, -0.2, -0.17, -0.1, 0};

  const bool first = which == 1;
  const auto phi = first ? spread_keys(phi1, frames) : spread_keys(phi2, frames);
  const auto theta = first ? spread_keys(theta1, frames) : spread_keys(theta2, frames);
  // The second swing's distances are smoothed without forcing the ends onto the keys.
  const auto r = first ? spread_keys(r1, frames) : smoothed(r2, frames);

  CameraPath path{{start}, {1.0}};
  for (long k = 1; k < frames; ++k) {
    const auto entry = static_cast<std::size_t>(k - 1);
    const double q = static_cast<double>(k) / static_cast<double>(frames);
    Rigid3 pose = turned(start, theta[entry], phi[entry]);
    pose.translation *= 1 + r[entry];
    path.subject_from_cam.push_back(pose);
    path.zoom.push_back(focal * q + (1 - q));
  }
  return path;
}

CameraPath lists_path(const OrbitLists& lists, const Rigid3& start, long frames) {
  lists.check();
  const auto phi = spread_keys(lists.phi, frames);
  const auto theta = spread_keys(lists.theta, frames);
  const auto r = spread_keys(lists.r, frames);
  CameraPath path;
  path.zoom.assign(phi.size(), 1.0);
  for (std::size_t k = 0; k < phi.size(); ++k) {
    Rigid3 pose = turned(start, theta[k], -phi[k]);
    // Smoothing may overshoot keys close to -1; the camera never passes through the subject.
    pose.translation *= std::max(1 + r[k], 1e-3);
    path.subject_from_cam.push_back(phi[k] == 0 && theta[k] == 0 && r[k] == 0 ? start : pose);
  }
  return path;
}

Rigid3 sphere_pose(const Rigid3& anchor, double theta, double phi, double r, double x, double y) {
  Rigid3 moved = anchor;
  moved.translation += Eigen::Vector3d(-x, y, -r);
  return turned(moved, theta, phi);
}

std::vector<Rigid3> sphere_path(const Rigid3& anchor, const OrbitLists& lists, long frames) {
  const auto phi = spread_keys(lists.phi, frames);
  const auto theta = spread_keys(lists.theta, frames);
  const auto r = spread_keys(lists.r, frames);
  std::vector<Rigid3> poses;
  for (std::size_t k = 0; k < phi.size(); ++k) poses.push_back(sphere_pose(anchor, theta[k], phi[k], r[k]));
  return poses;
}

std::vector<Rigid3> sphere_path(const Rigid3& anchor, double theta, double phi, double r, double x, double y,
                                long frames) {
  check_frames(frames);
  std::vector<Rigid3> poses;
  for (long k = 0; k < frames; ++k) {
    const double u = spread(k, frames);
    poses.push_back(sphere_pose(anchor, u * theta, u * phi, u * r, u * x, u * y));
  }
  return poses;
}

Eigen::Matrix3d rotation_from_vectors(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const double from_length = from.stableNorm();
  const double to_length = to.stableNorm();
  require(std::isfinite(from_length) && from_length > 0 && std::isfinite(to_length) && to_length > 0,
          "a rotation between vectors of lengths {} and {} is not defined", from_length, to_length);
  const Eigen::Vector3d a = from / from_length;
  const Eigen::Vector3d b = to / to_length;
  const Eigen::Vector3d normal = a.cross(b);
  const double sine = normal.norm();
  const double cosine = a.dot(b);
  if (sine < 1e-12) return cosine > 0 ? Eigen::Matrix3d(Eigen::Matrix3d::Identity()) : rotation_y(M_PI);
  return Eigen::AngleAxisd(std::atan2(sine, cosine), normal / sine).toRotationMatrix();
}

}  // namespace uwv
