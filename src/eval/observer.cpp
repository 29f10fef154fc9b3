// SPDX-License-Identifier: Apache-2.0
#include "observer.h"

namespace uwv {

Observer::Observer(const Scene& scene, const Camera& camera, double time)
    : camera_(camera), view_(scene, camera.world_from_cam.translation, time) {
  require(camera.size.width > 0 && camera.size.height > 0, "a camera needs a picture, not one of {}x{} pixels",
          camera.size.width, camera.size.height);
}

bool Observer::pixel_of(const Eigen::Vector3d& from_centre_in_world, int& x, int& y) const {
  Eigen::Vector2d pixel;
  if (!project(camera_.intrinsics, camera_.world_from_cam.rotation.transpose() * from_centre_in_world, pixel))
    return false;
  const bool inside =
      pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < camera_.size.width && pixel.y() < camera_.size.height;
  if (!inside) return false;
  x = static_cast<int>(pixel.x());
  y = static_cast<int>(pixel.y());
  return true;
}

bool Observer::unobstructed(const Eigen::Vector3d& from_centre_in_world) const {
  return !view_.blocked(from_centre_in_world, 1 - end_of_ray);
}

FirstHits first_hits(const Observer& observer, ThreadPool& pool) {
  const Camera& camera = observer.camera();
  FirstHits hits{Image<double>(camera.size), Image<std::int32_t>(camera.size, -1)};
  pool.for_ranges(0, camera.size.height, 4, [&](int from, int to) {
    for (int y = from; y < to; ++y) {
      for (int x = 0; x < camera.size.width; ++x) {
        const Hit hit = observer.view().first(pixel_direction(camera, x + 0.5, y + 0.5));
        hits.depth(x, y) = hit.distance;
        hits.object(x, y) = hit.object;
      }
    }
  });
  return hits;
}

}  // namespace uwv
