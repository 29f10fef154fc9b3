// SPDX-License-Identifier: Apache-2.0
// The synthetic scenes that tests, benchmarks and documentation share, and the camera moves made around them.
//
// World axes are those of an upright camera: x right, y down, z away. Sizes below are in units of `unit`.
#pragma once

#include <string>
#include <vector>

#include "uwv/eval/synthetic_scene.h"

namespace uwv {

struct StockOptions {
  /// The source picture; its horizontal field of view is 60 degrees at every size.
  Size size{832, 480};
  /// Where the subject sits in the world.
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  /// Scene units per unit of the descriptions below; 0.01 makes a scene of centimetres.
  double unit = 1;
  void check() const;
};

/// A scene with the camera that filmed it.
struct StockScene {
  std::string name;
  Scene scene;
  Camera source;
  Eigen::Vector3d subject_in_world;  ///< What orbits turn around; the source camera looks at it.
  double duration = 0;               ///< Seconds until motion ends; 0 = nothing moves.
};

/// A ball on a floor before a wall: a quarter of the picture wide, 3 from the camera, the wall 2 behind it.
StockScene sphere_floor_wall(const StockOptions& options = {});
/// Four turned boxes in a room with floor, ceiling and three walls; orbits up to 90 degrees stay inside.
StockScene boxes_room(const StockOptions& options = {});
/// Three rectangles tilted up to 60 degrees, one behind another, before a wall. They have no thickness: an orbit beyond
/// 45 degrees to the right or 20 to the left sees one of them from behind.
StockScene slanted_planes(const StockOptions& options = {});
/// A ball rolls from left to right past a standing box, 1.6 in one second.
StockScene moving_ball(const StockOptions& options = {});
/// Upright bars three pixels wide, nine apart, before a wall: the worst case for anything that looks at neighbours.
StockScene picket_fence(const StockOptions& options = {});
/// One wall parallel to the picture, 3 away: depth is the same everywhere. An orbit of 90 degrees ends inside
/// the wall's plane.
StockScene textured_plane(const StockOptions& options = {});
/// Floor, ceiling, two walls and an end 20 away: every depth from 2 to 20 in one picture. For moving forward; an orbit
/// leaves it through a wall at 15 degrees.
StockScene corridor(const StockOptions& options = {});
/// All of the above, in that order.
std::vector<StockScene> stock_scenes(const StockOptions& options = {});

/// The pose of a camera at `eye` that looks at `subject`, upright with respect to world y = down. Throws
/// std::invalid_argument when it would look straight up or down, or nowhere.
Rigid3 look_at(const Eigen::Vector3d& eye_in_world, const Eigen::Vector3d& subject_in_world);

/// `camera` turned around the vertical line through the subject by `angle` radians; positive moves it to its right.
/// Distance to the subject, height and lens stay.
Camera orbit_camera(const Camera& camera, const Eigen::Vector3d& subject_in_world, double angle);
/// `camera` moved straight towards the subject until its distance is `share` of what it was: 0.5 comes 2x closer.
Camera approach_camera(const Camera& camera, const Eigen::Vector3d& subject_in_world, double share);

}  // namespace uwv
