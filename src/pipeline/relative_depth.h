// SPDX-License-Identifier: Apache-2.0
// Depth given up to scale and shift, brought to the scale of estimated cameras (paper, the alignment of D_fine;
// geometry sheet 4.5).
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "uwv/core/thread_pool.h"
#include "uwv/geometry/depth_alignment.h"
#include "uwv/geometry/scene_geometry.h"
#include "uwv/geometry/structure_from_motion.h"
#include "uwv/pipeline/run_options.h"

namespace uwv::pipeline {

struct RelativeDepthOutcome {
  AlignmentSummary alignment;
  nlohmann::ordered_json facts;
};

/// How a file's relative depth is fitted. Throws std::invalid_argument for a kind that is not relative.
AlignmentOptions alignment_of(DepthKind kind);

/// `relative`: one picture a frame, of what `options` says. The reference is what `points` say of each frame where
/// there are any, else the depth already in `scene`. Puts the aligned depth into scene.frames, with a confidence of
/// `believed` where there is any; cameras and provider stay.
RelativeDepthOutcome bring_relative_depth_to_scale(std::span<const DepthMap> relative, const AlignmentOptions& options,
                                                   std::span<const ScenePoint> points, float believed,
                                                   SceneGeometry& scene, ThreadPool& pool, Monitor& monitor);

}  // namespace uwv::pipeline
