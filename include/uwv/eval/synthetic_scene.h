// SPDX-License-Identifier: Apache-2.0
// Scenes whose every answer is known exactly: planes, boxes and spheres, ray-cast in double precision. They are the
// ground truth for colour, depth, normals and visibility in tests, benchmarks and documentation.
//
// A surface point has one colour, whatever the camera and the time, as the point clouds we render assume. Rays start at
// a point in the world and go on in a direction of any length; distances along a ray count that length. With a
// direction whose z in the camera's frame is 1, distance is depth. Positions are subtracted before anything else is
// done with them, so a scene 1e7 units from the world's origin is as exact as one around it.
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "uwv/core/camera.h"
#include "uwv/core/image.h"
#include "uwv/core/thread_pool.h"
#include "uwv/eval/texture.h"
#include "uwv/geometry/slopes.h"

namespace uwv {

/// A rectangle of the object's plane z = 0, |x| <= half_width, |y| <= half_height; infinite unless told. It can be seen
/// from both sides; its normal is +z. Texture coordinates: (x, y, 0).
struct Plate {
  double half_width = std::numeric_limits<double>::infinity();
  double half_height = std::numeric_limits<double>::infinity();
};

/// |x| <= half.x and so on; normals point outwards. Texture coordinates: in-face coordinates, shifted from face to face
/// so that opposite faces differ.
struct Box {
  Eigen::Vector3d half = Eigen::Vector3d::Ones();
};

/// A ball around the object's origin; normals point outwards. Texture coordinates: (x, y, z).
struct Sphere {
  double radius = 1;
};

using Shape = std::variant<Plate, Box, Sphere>;

struct SceneObject {
  std::string name;
  Shape shape;
  Texture texture = Texture::flat({0.5F, 0.5F, 0.5F});
  Rigid3 world_from_object;
  /// `world_from_object` at a time in seconds, in place of the fixed one; empty = at rest.
  std::function<Rigid3(double time)> motion;
  /// 0..1: darkens the surface by its normal in the object's own frame, which makes form visible and yet leaves every
  /// surface point its one colour.
  double shading = 0;
};

/// Where a ray meets a surface.
struct Hit {
  int object = -1;                                             ///< Index into Scene::objects; -1 = nothing was hit.
  double distance = 0;                                         ///< In lengths of the ray's direction, > 0.
  Eigen::Vector3d normal_in_world = Eigen::Vector3d::Zero();   ///< Unit length, the shape's own (outward) side.
  Eigen::Vector3d normal_in_object = Eigen::Vector3d::Zero();  ///< The same in the object's frame.
  Eigen::Vector3d x_in_texture = Eigen::Vector3d::Zero();      ///< Texture coordinates.
  explicit operator bool() const { return object >= 0; }
};

/// One crossing of a ray with a surface, entering or leaving an object.
struct Crossing {
  int object = -1;
  double distance = 0;  ///< In lengths of the ray's direction, > 0.
};

struct Scene {
  std::vector<SceneObject> objects;
  Colour background = Colour::Zero();  ///< Where a ray hits nothing.

  /// The nearest surface along the ray. For many rays from one point, SceneView is faster.
  Hit trace(const Eigen::Vector3d& origin_in_world, const Eigen::Vector3d& direction_in_world, double time) const;
  /// The colour of a surface point, or the background.
  Colour colour(const Hit& hit) const;
};

/// A scene at one instant, looked at from one point; the scene outlives it. Reading is thread-safe.
class SceneView {
 public:
  SceneView(const Scene& scene, const Eigen::Vector3d& origin_in_world, double time);

  /// The nearest surface.
  Hit first(const Eigen::Vector3d& direction_in_world) const;
  /// True when any surface lies at a distance in (0, until).
  bool blocked(const Eigen::Vector3d& direction_in_world, double until) const;
  /// All crossings at distances in (0, until), nearest first. `out` is overwritten.
  void crossings(const Eigen::Vector3d& direction_in_world, double until, std::vector<Crossing>& out) const;
  /// Normals and texture coordinates of a crossing found along that direction.
  Hit resolve(const Eigen::Vector3d& direction_in_world, const Crossing& crossing) const;

  const Eigen::Vector3d& origin_in_world() const { return origin_in_world_; }
  const Scene& scene() const { return *scene_; }

 private:
  struct Placed {
    Eigen::Matrix3d object_from_world;
    Eigen::Vector3d origin_in_object;
  };
  /// Calls go_on(crossing) for every crossing at a positive distance, in no order, until it answers false.
  template <class Visitor>
  void for_each_crossing(const Eigen::Vector3d& direction_in_world, const Visitor& go_on) const;

  const Scene* scene_;
  Eigen::Vector3d origin_in_world_;
  std::vector<Placed> placed_;
};

/// What a camera sees of a scene. All have the camera's size.
struct SyntheticFrame {
  ImageRgb colour;
  DepthMap depth;              ///< At pixel centres, correctly rounded to float; 0 = nothing hit.
  NormalMap normals;           ///< At pixel centres, camera frame, turned towards the camera; zero = nothing hit.
  Image<std::int32_t> object;  ///< At pixel centres, index into Scene::objects; -1 = nothing hit.
};

/// Direction through a point of the picture (pixels, centres at +0.5), in the world, with z = 1 in the camera's frame.
Eigen::Vector3d pixel_direction(const Camera& camera, double u, double v);

/// Renders by ray casting. Colour is the mean of supersample^2 rays per pixel (>= 1), all else one ray through the
/// pixel's centre.
SyntheticFrame render(const Scene& scene, const Camera& camera, double time, ThreadPool& pool, int supersample = 1);

}  // namespace uwv
