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

/// `frames` have the working size, and so have `known` intrinsics. Throws Error(value_invalid) when a provider was asked
/// for that the pictures do not allow. `monitor` is warned when depth is an assumption.
EstimatedGeometry estimate_geometry(const RunOptions& options, std::span<const ImageRgb> frames,
                                    const std::optional<Intrinsics>& known, ThreadPool& pool, Monitor& monitor);

}  // namespace uwv::pipeline
