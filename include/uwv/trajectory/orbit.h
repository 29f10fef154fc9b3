// SPDX-License-Identifier: Apache-2.0
// The official camera paths around the subject, number for number (reference sheet, section 3).
//
// Everything happens in the subject world (subject_world.h): origin on the subject, x right, y down, z away from the
// first camera. Angles are degrees. Positive `phi` moves the camera to the left around the subject, positive `theta`
// down. Paths come out as poses and zoom factors, one per frame; frame 0 is the start camera itself, unchanged to the
// last bit.
//
// Habits of the official code that these functions keep, because its outputs contain them: rotation and distance reach
// their final value in the last frame, but offsets and zoom only (n-1)/n of it; offsets are scaled by the distance
// factor too; the swings use the smoothed tables one entry late and never reach the last one.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "uwv/core/camera.h"
#include "uwv/trajectory/easing.h"

namespace uwv {

/// Poses and zoom factors, one per frame.
struct CameraPath {
  std::vector<Rigid3> subject_from_cam;
  std::vector<double> zoom;  ///< Multiplies fx and fy; positive.
};

/// The free move: a turn about the subject, a sideways offset, a change of distance and a zoom, all at once.
struct FreeMove {
  double d_phi = 0;    ///< Final angle around the vertical axis, degrees; > 0 left. Any size: -360 is a full circle.
  double d_theta = 0;  ///< Final angle around the horizontal axis, degrees; > 0 down.
  double d_r = 1;      ///< Final distance to the subject as a multiple of the first; > 1 away. Positive.
  double x = 0;        ///< Final offset to the right, in radii.
  double y = 0;        ///< Final offset downwards, in radii.
  double z = 0;        ///< Final offset forward, in radii.
  double focal = 1;    ///< Final zoom: multiplies the focal length. Positive.
  Easing easing = Easing::linear;  ///< The official code knows only linear.
  /// Apply the zoom twice, as the official code does for photos (it edits one tensor in two calls).
  bool zoom_twice = false;

  void check() const;
  friend bool operator==(const FreeMove&, const FreeMove&) = default;
};

/// The three lists of a ViewCrafter trajectory text, each of any length: positions spread evenly over the path. Lists
/// of more than 3 values are smoothed (smoothing_spline.h) with their ends kept, shorter ones are joined by lines.
/// Signs are ViewCrafter's: phi > 0 moves to the **right**, theta > 0 down; r is added to the distance, in radii, so
/// that negative values move forward.
struct OrbitLists {
  std::vector<double> phi{0};    ///< Degrees.
  std::vector<double> theta{0};  ///< Degrees.
  std::vector<double> r{0};      ///< Share of the radius, > -1.

  void check() const;
  friend bool operator==(const OrbitLists&, const OrbitLists&) = default;
};

/// The path of a free move. `offset_radius` is the length of one unit of x, y, z: the radius for photos, radius *
/// radius_scale for videos. `frames` >= 1.
CameraPath free_path(const FreeMove& move, const Rigid3& start, double offset_radius, long frames);

/// The swings 1 and 2: small loops around the start camera, from tables; `focal` as in FreeMove.
CameraPath swing_path(int which, double focal, const Rigid3& start, long frames);

/// The path of a trajectory text.
CameraPath lists_path(const OrbitLists& lists, const Rigid3& start, long frames);

/// The values of one list at every frame: linear for up to 3 keys, else smoothed with both ends forced onto the keys.
std::vector<double> spread_keys(std::span<const double> keys, long frames);

/// The official helpers that its demo no longer calls: move the anchor by (-x, y, -r) in world axes, then turn it by
/// theta about the x axis and by phi about the y axis (degrees, signs as in FreeMove).
Rigid3 sphere_pose(const Rigid3& anchor, double theta, double phi, double r, double x = 0, double y = 0);
/// sphere_pose for every frame of a trajectory text, with the text's own signs (`generate_traj_txt`).
std::vector<Rigid3> sphere_path(const Rigid3& anchor, const OrbitLists& lists, long frames);
/// sphere_pose with all five values growing linearly from 0 (`generate_traj_specified`).
std::vector<Rigid3> sphere_path(const Rigid3& anchor, double theta, double phi, double r, double x, double y,
                                long frames);

/// The rotation that turns the direction of `from` onto that of `to` about their common normal. Parallel vectors give
/// the identity; opposite ones, where every normal would do, half a turn about y, the official code's choice (it maps
/// `from` onto `to` only if both are perpendicular to y). Throws std::invalid_argument for a zero or non-finite vector.
Eigen::Matrix3d rotation_from_vectors(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// A preset's name and what it does, for help texts.
struct PresetInfo {
  std::string_view name;
  std::string_view description;
};
/// All presets: the official free1..free5, orbit, swing1, swing2, and plain-word moves (left, right, up, ...).
std::span<const PresetInfo> presets();
bool is_preset(std::string_view name);
/// The path of a preset; `focal` is a final zoom on top of it. The name must be one of presets().
CameraPath preset_path(std::string_view name, double focal, const Rigid3& start, double offset_radius, long frames);

}  // namespace uwv
