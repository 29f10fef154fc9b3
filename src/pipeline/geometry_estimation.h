// SPDX-License-Identifier: Apache-2.0
// Depth and cameras of a clip that comes with neither: chooses a provider, says why, and runs it.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <vector>

#include "uwv/core/thread_pool.h"
#include "uwv/geometry/layers.h"
#include "uwv/geometry/scene_geometry.h"
#include "uwv/pipeline/run_options.h"

namespace uwv::pipeline {

/// The scene without its foreground, as a second cloud behind the first.
struct BackgroundLayer {
  std::vector<ImageRgb> colour;
  std::vector<DepthMap> depth;
};

struct EstimatedGeometry {
  SceneGeometry scene;
  std::vector<ForegroundMask> foreground;  ///< One a frame, or none.
  BackgroundLayer background;              ///< One of each a frame, or none.
  nlohmann::ordered_json facts;            ///< What was decided and why, what was skipped, seconds: for run.json.
};

/// `frames` have the working size, and so have `known` intrinsics. `relative` is empty, or has one picture a frame of
/// what options.depth_kind says, which is brought to the scale of the estimate. Throws Error(value_invalid) when a
/// provider was asked for that the pictures do not allow. `monitor` is warned when depth is an assumption.
EstimatedGeometry estimate_geometry(const RunOptions& options, std::span<const ImageRgb> frames,
                                    std::span<const DepthMap> relative, const std::optional<Intrinsics>& known,
                                    ThreadPool& pool, Monitor& monitor);

}  // namespace uwv::pipeline
