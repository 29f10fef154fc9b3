// SPDX-License-Identifier: Apache-2.0
#include "uwv/trajectory/subject_world.h"

#include <cmath>

#include "trajectory/rotations.h"

namespace uwv {

Rigid3 initial_camera(double elevation_deg, double radius) {
  const Eigen::Matrix3d tilt = detail::rotation_x(-detail::radians(elevation_deg));
  return {tilt, tilt * Eigen::Vector3d(0, 0, -radius)};
}

SubjectWorld::SubjectWorld(const Rigid3& world_from_cam0, double elevation_deg, double radius)
    : world_from_cam0_(world_from_cam0), subject_from_cam0_(initial_camera(elevation_deg, radius)), radius_(radius) {
  require(std::isfinite(radius) && radius > 0, "the radius of the subject world is {}; a positive number is wanted",
          radius);
  require(std::isfinite(elevation_deg), "the elevation is {}; a finite number is wanted", elevation_deg);
  require(world_from_cam0.rotation.allFinite() && world_from_cam0.translation.allFinite(),
          "the first source camera's pose holds NaN or Inf");
}

Rigid3 SubjectWorld::subject_from_cam(const Rigid3& world_from_cam) const {
  if (world_from_cam == world_from_cam0_) return subject_from_cam0_;
  // Subtract the centres first: both may be millions of units away from the world's origin.
  const Eigen::Matrix3d cam0_from_world = world_from_cam0_.rotation.transpose();
  const Rigid3 cam0_from_cam{cam0_from_world * world_from_cam.rotation,
                             cam0_from_world * (world_from_cam.translation - world_from_cam0_.translation)};
  return subject_from_cam0_ * cam0_from_cam;
}

Rigid3 SubjectWorld::world_from_cam(const Rigid3& subject_from_cam) const {
  if (subject_from_cam == subject_from_cam0_) return world_from_cam0_;
  return world_from_cam0_ * (subject_from_cam0_.inverse() * subject_from_cam);
}

Eigen::Vector3d SubjectWorld::point_in_subject(const Eigen::Vector3d& x_in_world) const {
  const Eigen::Vector3d from_cam0 = x_in_world - world_from_cam0_.translation;
  return subject_from_cam0_ * (world_from_cam0_.rotation.transpose() * from_cam0);
}

}  // namespace uwv
