// SPDX-License-Identifier: Apache-2.0
#include "uwv/eval/synthetic_scene.h"

#include <algorithm>
#include <cmath>

#include "shape.h"
#include "uwv/core/depth.h"

namespace uwv {
namespace {

Rgb8 to_rgb8(const Colour& colour) {
  const auto byte = [](float v) { return static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(v, 0.0F, 1.0F))); };
  return {byte(colour[0]), byte(colour[1]), byte(colour[2])};
}

Colour pixel_colour(const SceneView& view, const Camera& camera, int x, int y, int supersample) {
  Colour sum = Colour::Zero();
  for (int j = 0; j < supersample; ++j) {
    for (int i = 0; i < supersample; ++i) {
      const Eigen::Vector3d direction =
          pixel_direction(camera, x + (i + 0.5) / supersample, y + (j + 0.5) / supersample);
      sum += view.scene().colour(view.first(direction));
    }
  }
  return sum / static_cast<float>(supersample * supersample);
}

void render_pixel(const SceneView& view, const Camera& camera, int supersample, int x, int y, SyntheticFrame& out) {
  const Eigen::Vector3d direction = pixel_direction(camera, x + 0.5, y + 0.5);
  const Hit hit = view.first(direction);
  const Colour colour = supersample == 1 ? view.scene().colour(hit) : pixel_colour(view, camera, x, y, supersample);
  out.colour(x, y) = to_rgb8(colour);
  out.object(x, y) = hit.object;
  if (!hit) return;
  const float depth = static_cast<float>(hit.distance);
  out.depth(x, y) = is_valid_depth(depth) ? depth : 0.0F;
  const double towards_camera = hit.normal_in_world.dot(direction) > 0 ? -1.0 : 1.0;
  out.normals(x, y) =
      (towards_camera * (camera.world_from_cam.rotation.transpose() * hit.normal_in_world)).cast<float>();
}

}  // namespace

Hit Scene::trace(const Eigen::Vector3d& origin_in_world, const Eigen::Vector3d& direction_in_world, double time) const {
  return SceneView(*this, origin_in_world, time).first(direction_in_world);
}

Colour Scene::colour(const Hit& hit) const {
  if (!hit) return background;
  const SceneObject& object = objects[static_cast<std::size_t>(hit.object)];
  const Colour colour = object.texture.at(hit.x_in_texture);
  if (object.shading == 0) return colour;
  static const Eigen::Vector3d lit_side = Eigen::Vector3d(-0.4, -0.8, -0.45).normalized();
  const double light = 0.5 + 0.5 * hit.normal_in_object.dot(lit_side);
  return colour * static_cast<float>(1 - object.shading * (1 - light));
}

SceneView::SceneView(const Scene& scene, const Eigen::Vector3d& origin_in_world, double time)
    : scene_(&scene), origin_in_world_(origin_in_world) {
  placed_.reserve(scene.objects.size());
  for (const SceneObject& object : scene.objects) {
    const Rigid3 world_from_object = object.motion ? object.motion(time) : object.world_from_object;
    const Eigen::Matrix3d object_from_world = world_from_object.rotation.transpose();
    placed_.push_back({object_from_world, object_from_world * (origin_in_world - world_from_object.translation)});
  }
}

template <class Visitor>
void SceneView::for_each_crossing(const Eigen::Vector3d& direction_in_world, const Visitor& go_on) const {
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    const ShapeCrossings found =
        cross(scene_->objects[i].shape, placed_[i].origin_in_object, placed_[i].object_from_world * direction_in_world);
    for (std::size_t k = 0; k < found.count; ++k)
      if (found.distance[k] > 0 && !go_on(Crossing{static_cast<int>(i), found.distance[k]})) return;
  }
}

Hit SceneView::first(const Eigen::Vector3d& direction_in_world) const {
  Crossing nearest;
  for_each_crossing(direction_in_world, [&](const Crossing& crossing) {
    if (nearest.object < 0 || crossing.distance < nearest.distance) nearest = crossing;
    return true;
  });
  return nearest.object < 0 ? Hit{} : resolve(direction_in_world, nearest);
}

bool SceneView::blocked(const Eigen::Vector3d& direction_in_world, double until) const {
  bool found = false;
  for_each_crossing(direction_in_world, [&](const Crossing& crossing) {
    found = crossing.distance < until;
    return !found;
  });
  return found;
}

void SceneView::crossings(const Eigen::Vector3d& direction_in_world, double until, std::vector<Crossing>& out) const {
  out.clear();
  for_each_crossing(direction_in_world, [&](const Crossing& crossing) {
    if (crossing.distance < until) out.push_back(crossing);
    return true;
  });
  std::sort(out.begin(), out.end(), [](const Crossing& a, const Crossing& b) { return a.distance < b.distance; });
}

Hit SceneView::resolve(const Eigen::Vector3d& direction_in_world, const Crossing& crossing) const {
  const std::size_t i = static_cast<std::size_t>(crossing.object);
  const Eigen::Vector3d x_in_object =
      placed_[i].origin_in_object + crossing.distance * (placed_[i].object_from_world * direction_in_world);
  const SurfacePoint point = surface_point(scene_->objects[i].shape, x_in_object);
  return {crossing.object, crossing.distance, placed_[i].object_from_world.transpose() * point.normal, point.normal,
          point.x_in_texture};
}

Eigen::Vector3d pixel_direction(const Camera& camera, double u, double v) {
  return camera.world_from_cam.rotation * unproject(camera.intrinsics, {u, v}, 1.0);
}

SyntheticFrame render(const Scene& scene, const Camera& camera, double time, ThreadPool& pool, int supersample) {
  require(camera.size.width > 0 && camera.size.height > 0, "cannot render a picture of {}x{} pixels", camera.size.width,
          camera.size.height);
  require(supersample >= 1, "supersample must be at least 1, not {}", supersample);
  const SceneView view(scene, camera.world_from_cam.translation, time);
  SyntheticFrame out{ImageRgb(camera.size), DepthMap(camera.size), NormalMap(camera.size, Eigen::Vector3f::Zero()),
                     Image<std::int32_t>(camera.size)};
  pool.for_ranges(0, camera.size.height, 4, [&](int from, int to) {
    for (int y = from; y < to; ++y)
      for (int x = 0; x < camera.size.width; ++x) render_pixel(view, camera, supersample, x, y, out);
  });
  return out;
}

}  // namespace uwv
