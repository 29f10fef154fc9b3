// SPDX-License-Identifier: Apache-2.0
// What moves by itself before a moving camera: found, made whole, given a depth, and the scene behind it completed.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "pipeline/geometry_estimation.h"
#include "uwv/core/thread_pool.h"
#include "uwv/geometry/moving_objects.h"

namespace uwv::pipeline {

/// The moving pixels of a clip whose cameras are known. Where enough moves to matter, what the first frame is about is
/// looked for as well, and what of it moves is kept whole. Fills in `facts`: "moving_pixels".
/// `coarse` is empty, or the depth of each frame where it is known already.
MovingPixels find_moving_layer(const RunOptions& options, const ForegroundNetworks& networks,
                               std::span<const ImageRgb> frames, std::span<const Camera> cameras,
                               std::span<const FrameGeometry> coarse, ThreadPool& pool, Monitor& monitor,
                               nlohmann::ordered_json& facts);

/// Whether so much moves that it is kept apart from the static scene.
bool matters(const MovingPixels& moving);

/// Takes what moves for the foreground and, unless options.layers is off, completes the background behind it. Its fact
/// is "background". `result.scene` has depth and cameras of everything.
void lay_behind_moving(const RunOptions& options, std::span<const ImageRgb> frames, const MovingPixels& moving,
                       ThreadPool& pool, Monitor& monitor, EstimatedGeometry& result);

/// Gives what moves a depth, a foreground mask and, unless options.layers is off, a background. Its facts are
/// "moving_depth" and "background". Returns one line on what was done. `result.scene` has depth and cameras of the
/// static scene.
std::string place_moving_layer(const RunOptions& options, std::span<const ImageRgb> frames, const MovingPixels& moving,
                               ThreadPool& pool, Monitor& monitor, EstimatedGeometry& result);

}  // namespace uwv::pipeline
