// SPDX-License-Identifier: Apache-2.0
// Rotations about the axes of the subject world, in the official code's directions.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace uwv::detail {

inline double radians(double degrees) { return degrees * (M_PI / 180.0); }
inline double degrees(double radians) { return radians * (180.0 / M_PI); }

/// Turns y towards z: a camera in front of the subject (z < 0) moves down for positive angles.
inline Eigen::Matrix3d rotation_x(double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  Eigen::Matrix3d r;
  r << 1, 0, 0, 0, c, -s, 0, s, c;
  return r;
}

/// Turns z towards x: a camera in front of the subject moves left for positive angles.
inline Eigen::Matrix3d rotation_y(double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  Eigen::Matrix3d r;
  r << c, 0, s, 0, 1, 0, -s, 0, c;
  return r;
}

/// Turns x towards y: clockwise as the camera itself sees it.
inline Eigen::Matrix3d rotation_z(double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  Eigen::Matrix3d r;
  r << c, -s, 0, s, c, 0, 0, 0, 1;
  return r;
}

}  // namespace uwv::detail
