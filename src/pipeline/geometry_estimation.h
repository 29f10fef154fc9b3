// SPDX-License-Identifier: Apache-2.0
// Depth and cameras of a clip that comes with neither: chooses a provider, says why, and runs it.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/clip_foreground.h"
#include "uwv/core/thread_pool.h"
#include "uwv/geometry/layers.h"
#include "uwv/geometry/scene_geometry.h"
#include "uwv/model/depth_network.h"
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

/// The clip and what the options say of it; borrowed.
struct ClipToEstimate {
  std::span<const ImageRgb> frames;    ///< Working size.
  std::span<const DepthMap> relative;  ///< Empty, or one a frame of what options.depth_kind says.
  std::optional<Intrinsics> known;     ///< For the working size.
  DepthNetwork* network = nullptr;     ///< What options.depth_model names.
  const ForegroundNetworks& foreground_networks;
};

/// Relative depth is brought to the scale of the estimate. Throws Error(value_invalid) when a provider was asked for
/// that the pictures do not allow. `monitor` is warned when depth is an assumption.
EstimatedGeometry estimate_geometry(const RunOptions& options, const ClipToEstimate& clip, ThreadPool& pool,
                                    Monitor& monitor);

}  // namespace uwv::pipeline
