// SPDX-License-Identifier: Apache-2.0
#include "uwv/core/camera.h"

#include <Eigen/SVD>
#include <cmath>

namespace uwv {

Eigen::Matrix4d Rigid3::matrix() const {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = rotation;
  m.topRightCorner<3, 1>() = translation;
  return m;
}

Rigid3 Rigid3::from_matrix(const Eigen::Matrix4d& target_from_source, std::string_view what, double tolerance) {
  if (!target_from_source.allFinite())
    fail(ErrorCode::value_invalid, "{}: the pose holds NaN or Inf; a finite 4x4 matrix is wanted", what);
  const Eigen::RowVector4d last = target_from_source.row(3);
  if ((last - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > tolerance)
    fail(ErrorCode::value_invalid, "{}: the pose's last row is {} {} {} {}; 0 0 0 1 is wanted (is it transposed?)",
         what, last[0], last[1], last[2], last[3]);
  const Eigen::Matrix3d r = target_from_source.topLeftCorner<3, 3>();
  const double deviation = (r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(deviation <= tolerance))
    fail(ErrorCode::value_invalid,
         "{}: the pose's rotation is not orthonormal (max |R^T R - I| is {:.3g}, at most {:g} is accepted)", what,
         deviation, tolerance);
  if (r.determinant() < 0)
    fail(ErrorCode::value_invalid, "{}: the pose mirrors (determinant {:.3g}); a rotation is wanted", what,
         r.determinant());
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(r, Eigen::ComputeFullU | Eigen::ComputeFullV);
  // A matrix that is a rotation to the last bit stays as it is, so that equal poses stay equal.
  const Eigen::Matrix3d rotation = deviation < 1e-12 ? r : Eigen::Matrix3d(svd.matrixU() * svd.matrixV().transpose());
  return {rotation, target_from_source.topRightCorner<3, 1>()};
}

Eigen::Matrix3d Intrinsics::matrix() const {
  Eigen::Matrix3d k;
  k << fx, 0, cx, 0, fy, cy, 0, 0, 1;
  return k;
}

Eigen::Matrix3d Intrinsics::inverse_matrix() const {
  Eigen::Matrix3d k;
  k << 1 / fx, 0, -cx / fx, 0, 1 / fy, -cy / fy, 0, 0, 1;
  return k;
}

Intrinsics Intrinsics::resized(Size from, Size to) const {
  require(from.width > 0 && from.height > 0 && to.width > 0 && to.height > 0,
          "cannot resize a camera from {}x{} to {}x{}", from.width, from.height, to.width, to.height);
  const double sx = static_cast<double>(to.width) / from.width;
  const double sy = static_cast<double>(to.height) / from.height;
  return {fx * sx, fy * sy, cx * sx, cy * sy};
}

Intrinsics Intrinsics::from_fov_x(double fov_x, Size size) {
  require(fov_x > 0 && fov_x < M_PI, "a field of view of {} rad is outside (0, pi)", fov_x);
  const double f = 0.5 * size.width / std::tan(0.5 * fov_x);
  return {f, f, 0.5 * size.width, 0.5 * size.height};
}

Rigid3 target_from_source(const Camera& target, const Camera& source) {
  const Eigen::Matrix3d world_from_target = target.world_from_cam.rotation;
  if (target.world_from_cam == source.world_from_cam) return {};  // exactly no motion, without rounding R^T R
  const Eigen::Vector3d between = source.world_from_cam.translation - target.world_from_cam.translation;
  // Equal rotations give exactly the identity for the same reason.
  const Eigen::Matrix3d rotation =
      world_from_target == source.world_from_cam.rotation
          ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
          : Eigen::Matrix3d(world_from_target.transpose() * source.world_from_cam.rotation);
  return {rotation, world_from_target.transpose() * between};
}

bool project(const Intrinsics& intrinsics, const Eigen::Vector3d& x_in_cam, Eigen::Vector2d& pixel) {
  if (!(x_in_cam.z() > 0)) return false;
  pixel = {intrinsics.fx * x_in_cam.x() / x_in_cam.z() + intrinsics.cx,
           intrinsics.fy * x_in_cam.y() / x_in_cam.z() + intrinsics.cy};
  return true;
}

Eigen::Vector3d unproject(const Intrinsics& intrinsics, const Eigen::Vector2d& pixel, double z) {
  return {(pixel.x() - intrinsics.cx) / intrinsics.fx * z, (pixel.y() - intrinsics.cy) / intrinsics.fy * z, z};
}

}  // namespace uwv
