// SPDX-License-Identifier: Apache-2.0
// What is true at the end of a camera path that starts from one source frame: the measure for M'' and M_vis of
// Algorithm 1 after several frames.
#pragma once

#include <vector>

#include "uwv/eval/stock_scenes.h"
#include "uwv/eval/visibility_truth.h"

namespace uwv {

/// A path and the truth about its last camera.
struct PathTruth {
  std::vector<Camera> cameras;
  VisibilityTruth last;     ///< Source pixels visible from the last camera: what M'' should be there.
  VisibilityTruth product;  ///< Visible from every camera of the path: what M_vis should be there.
};

/// `steps` (>= 1) cameras on an orbit around the scene's subject, at equal angles, of which the last has turned by
/// `angle` radians (orbit_camera says which way). The source camera itself is not among them.
std::vector<Camera> orbit_path(const StockScene& scene, double angle, int steps);

/// The truth about a path of at least one camera, all seeing the scene at the same `time` as `source`.
PathTruth path_truth(const Scene& scene, const Camera& source, std::vector<Camera> cameras, double time,
                     ThreadPool& pool);

}  // namespace uwv
