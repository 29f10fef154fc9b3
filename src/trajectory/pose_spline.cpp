// SPDX-License-Identifier: Apache-2.0
#include "uwv/trajectory/pose_spline.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "trajectory/rotations.h"
#include "uwv/core/error.h"

namespace uwv {
namespace {

/// The rotation vector (axis times angle in [0, pi]) of a rotation matrix. Through a quaternion: that stays accurate
/// both near no turn and near half a turn.
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& rotation) {
  Eigen::Quaterniond q(rotation);
  if (q.w() < 0) q.coeffs() *= -1;
  const double sine = q.vec().norm();
  if (sine < 1e-30) return Eigen::Vector3d::Zero();
  return q.vec() * (2 * std::atan2(sine, q.w()) / sine);
}

Eigen::Matrix3d rotation_matrix(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  if (angle < 1e-30) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
}

void check_times(std::span<const double> times, std::size_t keys) {
  require(!times.empty() && times.size() == keys, "a curve was given {} times for {} keys", times.size(), keys);
  for (std::size_t i = 0; i < times.size(); ++i)
    require(std::isfinite(times[i]) && (i == 0 || times[i - 1] < times[i]), "time {} of a curve, {}, does not increase",
            i, times[i]);
}

/// The key that starts the piece holding `time`, and where in the piece it lies, in [0, 1]. `times` has two or more.
struct Piece {
  std::size_t key;
  double length;
  double share;
};

Piece piece_at(const std::vector<double>& times, double time) {
  const auto right = std::upper_bound(times.begin() + 1, times.end() - 1, time);
  const auto key = static_cast<std::size_t>(right - times.begin()) - 1;
  const double length = times[key + 1] - times[key];
  return {key, length, std::clamp((time - times[key]) / length, 0.0, 1.0)};
}

/// The speed at key i of n, from the displacement of each piece, `step(i)` leading from key i to key i+1.
template <class Vector, class Step>
Vector speed_at(const std::vector<double>& times, std::size_t i, const Vector& zero, const Step& step) {
  const std::size_t last = times.size() - 1;
  if (last == 0) return zero;
  const auto length = [&](std::size_t key) { return times[key + 1] - times[key]; };
  if (i == 0) return step(0) / length(0);
  if (i == last) return step(last - 1) / length(last - 1);
  const double h0 = length(i - 1);
  const double h1 = length(i);
  const Vector before = step(i - 1) / h0;
  const Vector after = step(i) / h1;
  const Vector speed = (before * h1 + after * h0) / (h0 + h1);
  // Fritsch and Carlson's bound: a quick piece next to a slow one must not throw the curve past the slow one's end.
  const double limit = 3 * std::min(before.norm(), after.norm());
  const double length_of_speed = speed.norm();
  return length_of_speed > limit ? Vector(speed * (limit / length_of_speed)) : speed;
}

}  // namespace

PointSpline::PointSpline(std::span<const double> times, Eigen::MatrixXd points)
    : times_(times.begin(), times.end()), points_(std::move(points)), speeds_(points_.rows(), points_.cols()) {
  check_times(times, static_cast<std::size_t>(points_.cols()));
  const auto step = [&](std::size_t i) -> Eigen::VectorXd {
    const auto column = static_cast<Eigen::Index>(i);
    return points_.col(column + 1) - points_.col(column);
  };
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(points_.rows());
  for (std::size_t i = 0; i < times_.size(); ++i)
    speeds_.col(static_cast<Eigen::Index>(i)) = speed_at(times_, i, zero, step);
}

Eigen::VectorXd PointSpline::operator()(double time) const {
  if (times_.size() == 1 || time <= times_.front()) return points_.col(0);
  if (time >= times_.back()) return points_.col(points_.cols() - 1);
  const Piece piece = piece_at(times_, time);
  const auto i = static_cast<Eigen::Index>(piece.key);
  const double s = piece.share;
  // Cubic Hermite, written as an offset from the left key: two equal keys at rest stay there to the last bit.
  const Eigen::VectorXd step = points_.col(i + 1) - points_.col(i);
  return points_.col(i) + step * (s * s * (3 - 2 * s)) +
         piece.length * s * (1 - s) * (speeds_.col(i) * (1 - s) - speeds_.col(i + 1) * s);
}

std::size_t RotationSpline::first_ambiguous_turn(std::span<const Eigen::Matrix3d> rotations) {
  for (std::size_t i = 1; i < rotations.size(); ++i) {
    const double turn = rotation_vector(rotations[i - 1].transpose() * rotations[i]).norm();
    if (detail::degrees(turn) > max_turn_deg) return i;
  }
  return 0;
}

RotationSpline::RotationSpline(std::span<const double> times, std::vector<Eigen::Matrix3d> rotations)
    : times_(times.begin(), times.end()), rotations_(std::move(rotations)) {
  check_times(times, rotations_.size());
  const std::size_t ambiguous = first_ambiguous_turn(rotations_);
  require(ambiguous == 0, "rotations {} and {} of a curve are half a turn apart", ambiguous - 1, ambiguous);
  const auto step = [&](std::size_t i) -> Eigen::Vector3d {
    // Equal keys must give exactly zero, which R^T R does not.
    if (rotations_[i] == rotations_[i + 1]) return Eigen::Vector3d::Zero();
    return rotation_vector(rotations_[i].transpose() * rotations_[i + 1]);
  };
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < times_.size(); ++i) speeds_.push_back(speed_at(times_, i, zero, step));
}

Eigen::Matrix3d RotationSpline::operator()(double time) const {
  if (times_.size() == 1 || time <= times_.front()) return rotations_.front();
  if (time >= times_.back()) return rotations_.back();
  const Piece piece = piece_at(times_, time);
  if (piece.share == 0) return rotations_[piece.key];
  const Eigen::Matrix3d& from = rotations_[piece.key];
  const Eigen::Matrix3d& to = rotations_[piece.key + 1];
  const Eigen::Vector3d leaving = speeds_[piece.key] * (piece.length / 3);
  const Eigen::Vector3d arriving = speeds_[piece.key + 1] * (piece.length / 3);
  if (from == to && leaving.isZero(0) && arriving.isZero(0)) return from;
  const Eigen::Matrix3d first = from * rotation_matrix(leaving);
  const Eigen::Matrix3d second = to * rotation_matrix(-arriving);
  const Eigen::Vector3d across = rotation_vector(first.transpose() * second);
  const double s = piece.share;
  const double third = s * s * s;                      // cumulative Bernstein polynomials
  const double two = third + 3 * s * s * (1 - s);      // of degree 3:
  const double one = two + 3 * s * (1 - s) * (1 - s);  // sums of the last one, two and three
  return from * rotation_matrix(leaving * one) * rotation_matrix(across * two) * rotation_matrix(arriving * third);
}

LookAt look_at(const Eigen::Vector3d& position, const Eigen::Vector3d& target, double roll_deg,
               Eigen::Matrix3d& rotation) {
  const Eigen::Vector3d direction = target - position;
  const double distance = direction.stableNorm();
  // Relative to the coordinates' size: what is left of a difference of equal large numbers is rounding.
  if (!(distance > 1e-12 * std::max(position.stableNorm(), target.stableNorm()))) return LookAt::no_direction;
  const Eigen::Vector3d z = direction / distance;
  const Eigen::Vector3d down(0, 1, 0);
  const Eigen::Vector3d across = down.cross(z);
  constexpr double smallest_tilt = 1e-6;  // radians off the vertical below which "horizontal" is noise
  if (across.norm() < smallest_tilt) return LookAt::no_horizon;
  const Eigen::Vector3d x = across.normalized();
  Eigen::Matrix3d upright;
  upright << x, z.cross(x), z;
  rotation = roll_deg == 0 ? upright : Eigen::Matrix3d(upright * detail::rotation_z(detail::radians(roll_deg)));
  return LookAt::good;
}

}  // namespace uwv
