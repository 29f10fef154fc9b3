// SPDX-License-Identifier: Apache-2.0
// Rigid transforms and pinhole cameras.
//
// Axes: OpenCV's. x points right, y down, z forward along the viewing direction. Transforms are named
// `target_from_source` and points `x_in_frame`, so that  x_in_a = a_from_b * x_in_b  and  a_from_c = a_from_b *
// b_from_c read right and a wrong product reads wrong. Poses are double: differences of large coordinates are taken
// here, before anything is rounded to float.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "uwv/core/image.h"

namespace uwv {

/// A rotation followed by a translation: x_in_target = rotation * x_in_source + translation.
struct Rigid3 {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< Orthonormal, determinant +1.
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();   ///< Scene units.

  Rigid3 inverse() const { return {rotation.transpose(), -(rotation.transpose() * translation)}; }
  Eigen::Matrix4d matrix() const;

  /// From a 4x4 matrix. Throws Error(value_invalid) naming `what` when the matrix is not finite, its last row is not
  /// 0 0 0 1, or its rotation is further than `tolerance` from orthonormal (max |R^T R - I|) or mirrored; small
  /// deviations within the tolerance are projected onto the nearest rotation.
  static Rigid3 from_matrix(const Eigen::Matrix4d& target_from_source, std::string_view what, double tolerance = 1e-3);

  friend Rigid3 operator*(const Rigid3& a_from_b, const Rigid3& b_from_c) {
    return {a_from_b.rotation * b_from_c.rotation, a_from_b.rotation * b_from_c.translation + a_from_b.translation};
  }
  friend Eigen::Vector3d operator*(const Rigid3& a_from_b, const Eigen::Vector3d& x_in_b) {
    return a_from_b.rotation * x_in_b + a_from_b.translation;
  }
  friend bool operator==(const Rigid3& a, const Rigid3& b) {
    return a.rotation == b.rotation && a.translation == b.translation;
  }
};

/// Pinhole intrinsics in pixels, for pixel centres at (x + 0.5, y + 0.5):  u = fx * X / Z + cx,  v = fy * Y / Z + cy.
/// The reference code uses integer pixel centres with cx = W/2; its cx equals ours minus 0.5 (see docs/conventions.md).
struct Intrinsics {
  double fx = 0, fy = 0;  ///< Non-zero and finite. Negative values mirror (some data sets have y up).
  double cx = 0, cy = 0;

  Eigen::Matrix3d matrix() const;
  Eigen::Matrix3d inverse_matrix() const;
  /// For a picture resized from `from` to `to` (both axes independently): pixel edges stay pixel edges.
  Intrinsics resized(Size from, Size to) const;
  /// Centred principal point and square pixels; `fov_x` is the horizontal field of view in radians, in (0, pi).
  static Intrinsics from_fov_x(double fov_x, Size size);
  /// Converts between our pixel-centre rule and integer centres by shifting the principal point half a pixel.
  static Intrinsics from_integer_centres(double fx, double fy, double cx, double cy) {
    return {fx, fy, cx + 0.5, cy + 0.5};
  }
  friend bool operator==(const Intrinsics&, const Intrinsics&) = default;
};

/// A posed camera and the size of its picture.
struct Camera {
  Intrinsics intrinsics;
  Rigid3 world_from_cam;  ///< The pose: the camera's centre in the world is world_from_cam.translation.
  Size size;

  Rigid3 cam_from_world() const { return world_from_cam.inverse(); }
  friend bool operator==(const Camera&, const Camera&) = default;
};

/// `target_from_source` of two cameras, computed so that it stays accurate when both are far from the world's origin:
/// the centres are subtracted before anything is multiplied.
Rigid3 target_from_source(const Camera& target, const Camera& source);

/// Where a point of the camera's own frame lands, in pixels; z <= 0 (behind or on the camera plane) gives false.
bool project(const Intrinsics& intrinsics, const Eigen::Vector3d& x_in_cam, Eigen::Vector2d& pixel);

/// The point seen at `pixel` with depth z along the optical axis, in the camera's own frame.
Eigen::Vector3d unproject(const Intrinsics& intrinsics, const Eigen::Vector2d& pixel, double z);

}  // namespace uwv
