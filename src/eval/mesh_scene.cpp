// SPDX-License-Identifier: Apache-2.0
#include "uwv/eval/mesh_scene.h"

#include <algorithm>
#include <cmath>

#include "mesh_raster.h"
#include "uwv/core/depth.h"

namespace uwv {
namespace {

using Eigen::Vector3d;

Rgb8 to_rgb8(const Colour& colour) {
  const auto byte = [](float v) { return static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(v, 0.0F, 1.0F))); };
  return {byte(colour[0]), byte(colour[1]), byte(colour[2])};
}

/// The picture, repeated, between its four nearest pixels. Wrapped before it is rounded: coordinates may be huge.
Colour texture_at(const ImageRgb& texture, const Eigen::Vector2d& coordinates) {
  const double u = (coordinates.x() - std::floor(coordinates.x())) * texture.width() - 0.5;
  const double v = (coordinates.y() - std::floor(coordinates.y())) * texture.height() - 0.5;
  const double left = std::floor(u), top = std::floor(v);
  const auto wrapped = [](double i, int n) { return (static_cast<int>(i) + n) % n; };
  const int x0 = wrapped(left, texture.width()), x1 = (x0 + 1) % texture.width();
  const int y0 = wrapped(top, texture.height()), y1 = (y0 + 1) % texture.height();
  const auto colour = [&](int x, int y) {
    const Rgb8 pixel = texture(x, y);
    return Colour(pixel.r, pixel.g, pixel.b);
  };
  const auto right = static_cast<float>(u - left), down = static_cast<float>(v - top);
  return ((1 - down) * ((1 - right) * colour(x0, y0) + right * colour(x1, y0)) +
          down * ((1 - right) * colour(x0, y1) + right * colour(x1, y1))) /
         255.0F;
}

/// All instances at one instant, in one camera's frame.
class PosedScene {
 public:
  PosedScene(const MeshScene& scene, const Camera& camera, double time) : scene_(&scene) {
    for (std::size_t i = 0; i < scene.instances.size(); ++i) add(static_cast<int>(i), camera, time);
  }

  std::span<const ViewedTriangle> triangles() const { return triangles_; }
  int instance_of(std::int32_t triangle) const { return origins_[static_cast<std::size_t>(triangle)].instance; }

  Colour colour(std::int32_t triangle, const Vector3d& direction) const {
    if (triangle < 0) return scene_->background;
    const Origin& origin = origins_[static_cast<std::size_t>(triangle)];
    const MeshInstance& instance = scene_->instances[static_cast<std::size_t>(origin.instance)];
    const MeshModel& model = instance.model;
    const MeshTriangle& shape = model.triangles()[static_cast<std::size_t>(origin.triangle)];
    const Vector3d weights = triangles_[static_cast<std::size_t>(triangle)].weights(direction);
    const auto between = [&](const auto& values) {
      auto sum = (weights[0] * values[static_cast<std::size_t>(shape.corners[0])]).eval();
      for (int k = 1; k < 3; ++k)
        sum += weights[k] * values[static_cast<std::size_t>(shape.corners[static_cast<std::size_t>(k)])];
      return sum;
    };
    Colour colour = Colour::Ones();
    if (shape.material >= 0) {
      const MeshMaterial& material = model.materials()[static_cast<std::size_t>(shape.material)];
      colour = material.base;
      if (material.texture >= 0)
        colour = colour.cwiseProduct(texture_at(model.textures()[static_cast<std::size_t>(material.texture)],
                                                between(model.texture_coordinates())));
    }
    if (!instance.details.empty()) {
      const Vector3d x_at_rest = between(model.rest());
      const auto strength = static_cast<float>(instance.detail_strength);
      for (const Texture& detail : instance.details)
        colour = colour.cwiseProduct(Colour::Ones() + strength * (2 * detail.at(x_at_rest) - Colour::Ones()));
    }
    return colour * origin.light;
  }

 private:
  struct Origin {
    int instance = 0;
    int triangle = 0;  // in its model
    float light = 1;
  };

  void add(int index, const Camera& camera, double time) {
    const MeshInstance& instance = scene_->instances[static_cast<std::size_t>(index)];
    require(instance.scale > 0 && std::isfinite(instance.scale), "the scale of '{}' must be positive, not {}",
            instance.name, instance.scale);
    const MeshModel& model = instance.model;
    const Rigid3 world_from_model = instance.motion ? instance.motion(time) : instance.world_from_model;
    Camera model_as_camera;
    model_as_camera.world_from_cam = world_from_model;
    const Rigid3 cam_from_model = target_from_source(camera, model_as_camera);
    std::vector<Vector3d> x_in_cam =
        instance.animation.empty() ? model.rest() : model.posed(instance.animation, instance.animation_start + time);
    for (Vector3d& x : x_in_cam) x = cam_from_model * Vector3d(instance.scale * x);
    for (std::size_t k = 0; k < model.triangles().size(); ++k) {
      const MeshTriangle& shape = model.triangles()[k];
      const auto corner = [&](const std::vector<Vector3d>& all, std::size_t c) -> const Vector3d& {
        return all[static_cast<std::size_t>(shape.corners[c])];
      };
      triangles_.emplace_back(corner(x_in_cam, 0), corner(x_in_cam, 1), corner(x_in_cam, 2));
      const Vector3d normal =
          (corner(model.rest(), 1) - corner(model.rest(), 0)).cross(corner(model.rest(), 2) - corner(model.rest(), 0));
      origins_.push_back({index, static_cast<int>(k), light(normal, instance.shading)});
    }
  }

  static float light(const Vector3d& normal_in_model, double shading) {
    static const Vector3d lit_side = Vector3d(-0.4, 0.8, 0.45).normalized();  // y is up here
    const double length = normal_in_model.norm();
    if (length == 0) return 1;
    return static_cast<float>(1 - shading * (0.5 - 0.5 * normal_in_model.dot(lit_side) / length));
  }

  const MeshScene* scene_;
  std::vector<ViewedTriangle> triangles_;
  std::vector<Origin> origins_;
};

void fill_truth(const PosedScene& posed, const Image<std::int32_t>& nearest, const Intrinsics& lens,
                SyntheticFrame& out, int x, int y) {
  const std::int32_t index = nearest(x, y);
  if (index < 0) return;
  const ViewedTriangle& triangle = posed.triangles()[static_cast<std::size_t>(index)];
  const Vector3d direction = unproject(lens, {x + 0.5, y + 0.5}, 1.0);
  const auto depth = static_cast<float>(triangle.depth(direction));
  out.object(x, y) = posed.instance_of(index);
  out.depth(x, y) = is_valid_depth(depth) ? depth : 0.0F;
  const double towards_camera = triangle.normal.dot(direction) > 0 ? -1.0 : 1.0;
  out.normals(x, y) = (towards_camera * triangle.normal.normalized()).cast<float>();
}

}  // namespace

SyntheticFrame render(const MeshScene& scene, const Camera& camera, double time, ThreadPool& pool, int supersample) {
  require(camera.size.width > 0 && camera.size.height > 0, "cannot render a picture of {}x{} pixels", camera.size.width,
          camera.size.height);
  require(supersample >= 1, "supersample must be at least 1, not {}", supersample);
  const PosedScene posed(scene, camera, time);
  SyntheticFrame out{ImageRgb(camera.size), DepthMap(camera.size), NormalMap(camera.size, Eigen::Vector3f::Zero()),
                     Image<std::int32_t>(camera.size, -1)};
  const Image<std::int32_t> centres = nearest_triangles(posed.triangles(), camera.intrinsics, camera.size, pool);
  const Size fine{camera.size.width * supersample, camera.size.height * supersample};
  const Intrinsics fine_lens = camera.intrinsics.resized(camera.size, fine);
  const Image<std::int32_t> samples =
      supersample == 1 ? centres : nearest_triangles(posed.triangles(), fine_lens, fine, pool);
  pool.for_ranges(0, camera.size.height, 4, [&](int from, int to) {
    for (int y = from; y < to; ++y)
      for (int x = 0; x < camera.size.width; ++x) {
        fill_truth(posed, centres, camera.intrinsics, out, x, y);
        Colour sum = Colour::Zero();
        for (int v = y * supersample; v < (y + 1) * supersample; ++v)
          for (int u = x * supersample; u < (x + 1) * supersample; ++u)
            sum += posed.colour(samples(u, v), unproject(fine_lens, {u + 0.5, v + 0.5}, 1.0));
        out.colour(x, y) = to_rgb8(sum / static_cast<float>(supersample * supersample));
      }
  });
  return out;
}

}  // namespace uwv
