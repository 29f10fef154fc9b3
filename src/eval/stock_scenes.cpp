// SPDX-License-Identifier: Apache-2.0
#include "uwv/eval/stock_scenes.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace uwv {
namespace {

using Eigen::Vector3d;

constexpr double degree = std::numbers::pi / 180;

Eigen::Matrix3d turned(const Vector3d& axis, double angle) { return Eigen::AngleAxisd(angle, axis).toRotationMatrix(); }

const Colour cream{0.86F, 0.80F, 0.68F};
const Colour brown{0.42F, 0.26F, 0.14F};
const Colour brick{0.70F, 0.32F, 0.24F};
const Colour slate{0.30F, 0.36F, 0.44F};
const Colour sand{0.72F, 0.62F, 0.44F};
const Colour leaf{0.34F, 0.52F, 0.28F};
const Colour sky{0.46F, 0.60F, 0.76F};

// Builds a scene in its own small coordinates and places it in the world.
class Builder {
 public:
  Builder(std::string name, const StockOptions& options) : options_(options) {
    options.check();
    made_.name = std::move(name);
    made_.subject_in_world = options.origin;
    made_.source.size = options.size;
    made_.source.intrinsics = Intrinsics::from_fov_x(60 * degree, options.size);
  }

  // Textures are given their period in scene units by multiplying with this.
  double unit() const { return options_.unit; }
  Vector3d in_world(const Vector3d& x) const { return options_.origin + options_.unit * x; }

  SceneObject& add(std::string name, Shape shape, Texture texture, const Vector3d& position,
                   const Eigen::Matrix3d& rotation = Eigen::Matrix3d::Identity(), double shading = 0) {
    SceneObject object{std::move(name), std::move(shape), std::move(texture), {rotation, in_world(position)}, {}, 0};
    object.shading = shading;
    made_.scene.objects.push_back(std::move(object));
    return made_.scene.objects.back();
  }
  // Plates that face up, towards the camera, and sideways.
  void floor(double y, Texture texture) {
    add("floor", Plate{}, std::move(texture), {0, y, 0}, turned(Vector3d::UnitX(), 90 * degree));
  }
  void wall(double z, Texture texture) {
    add("wall", Plate{}, std::move(texture), {0, 0, z}, turned(Vector3d::UnitX(), 180 * degree));
  }
  void side(double x, Texture texture) {
    add("side", Plate{}, std::move(texture), {x, 0, 0}, turned(Vector3d::UnitY(), 90 * degree));
  }

  Texture noise(const Colour& mean, double period, std::uint64_t seed) const {
    return Texture::noise(mean, period * unit(), seed);
  }
  Texture checker(const Colour& a, const Colour& b, double period) const {
    return Texture::checker(a, b, period * unit());
  }
  Texture wood(double period, std::uint64_t seed) const { return Texture::wood(cream, brown, period * unit(), seed); }
  Texture gradient(const Colour& a, const Colour& b, double period) const {
    return Texture::gradient(a, b, period * unit());
  }
  Shape ball(double radius) const { return Sphere{radius * unit()}; }
  Shape box(double x, double y, double z) const { return Box{unit() * Vector3d(x, y, z)}; }
  Shape plate(double half_width, double half_height) const { return Plate{half_width * unit(), half_height * unit()}; }

  StockScene filmed_from(const Vector3d& eye) {
    made_.source.world_from_cam = look_at(in_world(eye), made_.subject_in_world);
    return std::move(made_);
  }
  void lasts(double seconds) { made_.duration = seconds; }

 private:
  StockOptions options_;
  StockScene made_;
};

// A camera `distance` away, looking down on the subject by `pitch`.
Vector3d eye_at(double distance, double pitch) { return {0, -distance * std::sin(pitch), -distance * std::cos(pitch)}; }

}  // namespace

void StockOptions::check() const {
  require(size.width > 0 && size.height > 0, "a stock scene cannot be filmed at {}x{} pixels", size.width, size.height);
  require(unit > 0 && std::isfinite(unit), "unit must be positive, not {}", unit);
  require(origin.allFinite(), "origin must be finite");
}

StockScene sphere_floor_wall(const StockOptions& options) {
  Builder b("sphere_floor_wall", options);
  // A ball of radius r seen at distance d is 2 f r / sqrt(d^2 - r^2) wide; a quarter of the picture at 60 degrees:
  const double tangent = 0.25 * std::tan(30 * degree);
  const double radius = 3 * tangent / std::sqrt(1 + tangent * tangent);
  b.add("ball", b.ball(radius), b.noise(brick, 0.06, 1), {0, 0, 0});
  b.floor(radius, b.wood(0.25, 2));
  b.wall(2, b.noise(slate, 0.1, 3));
  return b.filmed_from(eye_at(3, 10 * degree));
}

StockScene boxes_room(const StockOptions& options) {
  Builder b("boxes_room", options);
  b.floor(0.6, b.checker(cream, slate, 0.4));
  b.add("ceiling", Plate{}, b.noise(cream, 0.3, 4), {0, -1.8, 0}, turned(Vector3d::UnitX(), -90 * degree));
  b.wall(3.2, b.noise(sand, 0.12, 5));
  b.side(-3.2, b.noise(sky, 0.15, 6));
  b.side(3.2, b.gradient(leaf, cream, 0.8));
  b.add("crate", b.box(0.35, 0.35, 0.35), b.wood(0.06, 7), {-0.1, 0.25, 0}, turned(Vector3d::UnitY(), 0.5), 0.3);
  b.add("tower", b.box(0.2, 0.7, 0.2), b.noise(brick, 0.06, 8), {0.9, -0.1, 0.7}, turned(Vector3d::UnitY(), -0.3), 0.3);
  b.add("slab", b.box(0.5, 0.08, 0.3), b.checker(brick, cream, 0.1), {-1.0, 0.52, 0.9}, turned(Vector3d::UnitY(), 0.9),
        0.3);
  b.add("tumbling", b.box(0.2, 0.2, 0.2), b.noise(leaf, 0.05, 9), {0.6, 0.0, -0.5},
        turned(Vector3d(1, 2, 3).normalized(), 0.8), 0.3);
  return b.filmed_from(eye_at(3, 12 * degree));
}

StockScene slanted_planes(const StockOptions& options) {
  Builder b("slanted_planes", options);
  b.wall(3, b.noise(slate, 0.12, 10));
  b.add("left", b.plate(0.7, 0.6), b.noise(brick, 0.06, 11), {-0.9, 0.1, 0.6}, turned(Vector3d::UnitY(), 40 * degree));
  b.add("middle", b.plate(0.6, 0.5), b.checker(cream, leaf, 0.15), {0.05, -0.1, 0},
        turned(Vector3d(1, 0.3, 0).normalized(), -35 * degree));
  b.add("right", b.plate(0.8, 0.5), b.wood(0.07, 12), {1.0, 0.2, 0.8}, turned(Vector3d::UnitY(), -60 * degree));
  return b.filmed_from(eye_at(3, 0));
}

StockScene moving_ball(const StockOptions& options) {
  Builder b("moving_ball", options);
  const double radius = 0.3;
  const double ground = 0.4;
  const Vector3d start = b.in_world({-0.8, ground - radius, -0.4});
  const double unit = b.unit();
  SceneObject& ball = b.add("ball", b.ball(radius), b.noise(brick, 0.05, 13), {-0.8, ground - radius, -0.4});
  ball.motion = [start, unit, radius](double time) {
    const double way = 1.6 * time;
    return Rigid3{turned(Vector3d::UnitZ(), way / radius), start + unit * way * Vector3d::UnitX()};
  };
  b.add("box", b.box(0.25, 0.4, 0.25), b.wood(0.06, 14), {0.1, 0, 0.5}, turned(Vector3d::UnitY(), 0.6), 0.3);
  b.floor(ground, b.checker(cream, slate, 0.3));
  b.wall(2, b.noise(sky, 0.1, 15));
  b.lasts(1);
  return b.filmed_from(eye_at(3, 10 * degree));
}

StockScene picket_fence(const StockOptions& options) {
  Builder b("picket_fence", options);
  const double pixel = 3.0 * 2 * std::tan(30 * degree) / 832;  // at the fence, in the default picture
  // The odd spacing keeps bar edges off pixel centres, where rounding would decide.
  for (int i = -24; i <= 24; ++i)
    b.add("bar", b.box(1.5 * pixel, 0.8, 1.5 * pixel), b.noise(cream, 0.1, 22), {(9.3 * i + 0.2) * pixel, 0, 0});
  b.wall(1.5, b.noise(leaf, 0.08, 16));
  return b.filmed_from(eye_at(3, 0));
}

StockScene textured_plane(const StockOptions& options) {
  Builder b("textured_plane", options);
  b.wall(0, b.noise(sand, 0.06, 17));
  return b.filmed_from(eye_at(3, 0));
}

StockScene corridor(const StockOptions& options) {
  Builder b("corridor", options);
  const double subject = 5;  // of the way down the corridor, which ends 20 from the camera
  b.floor(1.0, b.wood(0.25, 18));
  b.add("ceiling", Plate{}, b.checker(cream, slate, 0.5), {0, -1.2, 0}, turned(Vector3d::UnitX(), -90 * degree));
  b.side(-1.3, b.noise(brick, 0.2, 19));
  b.side(1.3, b.noise(sky, 0.2, 20));
  b.wall(20 - subject, b.noise(leaf, 0.4, 21));
  return b.filmed_from({0, 0, -subject});
}

std::vector<StockScene> stock_scenes(const StockOptions& options) {
  std::vector<StockScene> all;
  for (StockScene (*make)(const StockOptions&) :
       {sphere_floor_wall, boxes_room, slanted_planes, moving_ball, picket_fence, textured_plane, corridor})
    all.push_back(make(options));
  return all;
}

Rigid3 look_at(const Vector3d& eye_in_world, const Vector3d& subject_in_world) {
  const Vector3d forward = subject_in_world - eye_in_world;
  const Vector3d right = Vector3d::UnitY().cross(forward);
  require(right.norm() > 1e-9 * forward.norm(), "look_at: the subject is straight above, below or at the camera");
  Rigid3 world_from_cam;
  world_from_cam.rotation.col(0) = right.normalized();
  world_from_cam.rotation.col(1) = forward.cross(right).normalized();
  world_from_cam.rotation.col(2) = forward.normalized();
  world_from_cam.translation = eye_in_world;
  return world_from_cam;
}

Camera orbit_camera(const Camera& camera, const Vector3d& subject_in_world, double angle) {
  if (angle == 0) return camera;
  // Seen from above with y down, a positive turn about y takes z to x: a camera before the subject moves to its left.
  const Eigen::Matrix3d turn = turned(Vector3d::UnitY(), -angle);
  Camera moved = camera;
  moved.world_from_cam.rotation = turn * camera.world_from_cam.rotation;
  moved.world_from_cam.translation = subject_in_world + turn * (camera.world_from_cam.translation - subject_in_world);
  return moved;
}

Camera approach_camera(const Camera& camera, const Vector3d& subject_in_world, double share) {
  Camera moved = camera;
  moved.world_from_cam.translation = subject_in_world + share * (camera.world_from_cam.translation - subject_in_world);
  return moved;
}

}  // namespace uwv
