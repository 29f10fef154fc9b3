// SPDX-License-Identifier: Apache-2.0
// Smooth curves through camera poses: positions, orientations, and cameras that look at a point.
//
// Both curves pass exactly through their keys and are once continuously differentiable in their parameter. A key's
// speed is the average of its two neighbours' chords, weighted so that the nearer neighbour counts more (the
// non-uniform Catmull-Rom rule), but at most three times the slower one (F. N. Fritsch, R. E. Carlson, "Monotone
// piecewise cubic interpolation", SIAM J. Numer. Anal. 17, 1980), so that the curve rests between equal keys and does
// not overshoot beside a quick piece; at the ends it is the only chord's. Orientations use the cumulative cubic Bezier
// form of M.-J. Kim, M.-S. Kim, S. Y. Shin, "A general construction scheme for unit quaternion curves with simple high
// order derivatives", SIGGRAPH 1995; they are computed from rotation matrices, so quaternion signs cannot matter.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace uwv {

/// A curve through points of any dimension. One key gives a constant, two a straight line at constant speed.
class PointSpline {
 public:
  /// `times` strictly increase; `points` has one column per time. Throws std::invalid_argument otherwise.
  PointSpline(std::span<const double> times, Eigen::MatrixXd points);
  /// Outside the times' range the first or last point.
  Eigen::VectorXd operator()(double time) const;

 private:
  std::vector<double> times_;
  Eigen::MatrixXd points_;
  Eigen::MatrixXd speeds_;
};

/// A curve through rotations, always the short way round. Two keys turn about one axis at constant speed.
class RotationSpline {
 public:
  /// Neighbouring keys further apart than this have no short way round: it would depend on rounding.
  static constexpr double max_turn_deg = 179.9;

  /// `times` strictly increase, one per rotation; rotations are orthonormal. Throws std::invalid_argument otherwise, or
  /// when first_ambiguous_turn() finds one.
  RotationSpline(std::span<const double> times, std::vector<Eigen::Matrix3d> rotations);
  /// Outside the times' range the first or last rotation.
  Eigen::Matrix3d operator()(double time) const;

  /// The index of the first key that is more than max_turn_deg away from the key before it; 0 when there is none.
  static std::size_t first_ambiguous_turn(std::span<const Eigen::Matrix3d> rotations);

 private:
  std::vector<double> times_;
  std::vector<Eigen::Matrix3d> rotations_;
  std::vector<Eigen::Vector3d> speeds_;  ///< Rotation vectors per unit of time, in the key's own axes.
};

/// How well a direction of view is defined.
enum class LookAt {
  good,
  no_direction,  ///< The camera is where it should look.
  no_horizon,    ///< It looks along the y axis, so that "upright" has no meaning.
};

/// The orientation of an upright camera at `position` that looks at `target`: z towards the target, x horizontal (no y
/// component), y downwards, then turned by `roll_deg` about z, clockwise as the camera sees it. `rotation` is written
/// only when the answer is `good`.
LookAt look_at(const Eigen::Vector3d& position, const Eigen::Vector3d& target, double roll_deg,
               Eigen::Matrix3d& rotation);

}  // namespace uwv
