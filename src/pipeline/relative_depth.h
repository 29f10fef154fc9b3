// SPDX-License-Identifier: Apache-2.0
// Depth given up to scale and shift, brought to the scale of estimated cameras (paper, the alignment of D_fine;
// geometry sheet 4.5).
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "uwv/core/thread_pool.h"
#include "uwv/geometry/scene_geometry.h"
#include "uwv/geometry/structure_from_motion.h"
#include "uwv/pipeline/run_options.h"

namespace uwv::pipeline {

struct RelativeDepthOutcome {
  nlohmann::ordered_json facts;
  std::string brief;
};

/// The reference is what `points` say of each frame where there are any, else the depth already in `scene`. Puts the
/// aligned depth into scene.frames.
RelativeDepthOutcome bring_relative_depth_to_scale(std::span<const ImageRgb> frames, std::span<const DepthMap> relative,
                                                   DepthKind kind, std::span<const ScenePoint> points,
                                                   SceneGeometry& scene, ThreadPool& pool, Monitor& monitor);

}  // namespace uwv::pipeline
