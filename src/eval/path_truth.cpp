// SPDX-License-Identifier: Apache-2.0
#include "uwv/eval/path_truth.h"

#include <utility>

namespace uwv {

std::vector<Camera> orbit_path(const StockScene& scene, double angle, int steps) {
  require(steps >= 1, "an orbit of {} steps has no camera", steps);
  std::vector<Camera> cameras;
  for (int k = 1; k <= steps; ++k)
    cameras.push_back(orbit_camera(scene.source, scene.subject_in_world, angle * k / steps));
  return cameras;
}

PathTruth path_truth(const Scene& scene, const Camera& source, std::vector<Camera> cameras, double time,
                     ThreadPool& pool) {
  require(!cameras.empty(), "a path without cameras has no truth");
  PathTruth path;
  path.cameras = std::move(cameras);
  for (const Camera& camera : path.cameras) {
    path.last = visibility_truth(scene, source, camera, time, pool);
    if (path.product.visible.empty())
      path.product = path.last;
    else
      accumulate(path.product, path.last);
  }
  return path;
}

}  // namespace uwv
