// SPDX-License-Identifier: Apache-2.0
// The world in which target paths are described: its origin lies on the subject, its y axis points down.
//
// The first source camera sits at distance `radius` from the origin and looks at it; `elevation` says how far above the
// subject's horizon that camera was, so that "horizontal" means what it should (the official `set_initial_camera`,
// reference sheet section 1; alignment of the other cameras: section 4.2). Only rigid motion: depths keep their scale.
#pragma once

#include "uwv/core/camera.h"

namespace uwv {

/// The pose of the first source camera in the subject world: Rx(-elevation) * Translate(0, 0, -radius), with Rx(a)
/// turning y towards z. `elevation_deg` > 0 puts the camera above the origin (y < 0), looking down; `radius` > 0, scene
/// units.
Rigid3 initial_camera(double elevation_deg, double radius);

/// Converts between the world the source cameras were given in and the subject world. Exact to double rounding of the
/// distances to the first camera, even when the source world's origin is far away.
class SubjectWorld {
 public:
  /// A source that starts at the origin of its world; no elevation, radius 1.
  SubjectWorld() : SubjectWorld(Rigid3{}, 0, 1) {}
  /// `world_from_cam0`: the first source camera in the source world. Throws std::invalid_argument unless radius is
  /// positive and everything is finite.
  SubjectWorld(const Rigid3& world_from_cam0, double elevation_deg, double radius);

  const Rigid3& subject_from_cam0() const { return subject_from_cam0_; }
  double radius() const { return radius_; }

  Rigid3 subject_from_cam(const Rigid3& world_from_cam) const;
  Rigid3 world_from_cam(const Rigid3& subject_from_cam) const;
  Eigen::Vector3d point_in_subject(const Eigen::Vector3d& x_in_world) const;

 private:
  Rigid3 world_from_cam0_;
  Rigid3 subject_from_cam0_;
  double radius_;
};

}  // namespace uwv
