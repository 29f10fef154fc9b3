// SPDX-License-Identifier: Apache-2.0
// Clips that cut: what was estimated is of one shot, and the frames of the others must not pass for it.
#pragma once

#include <optional>
#include <span>

#include "pipeline/geometry_estimation.h"
#include "uwv/core/thread_pool.h"
#include "uwv/geometry/structure_from_motion.h"

namespace uwv::pipeline {

/// A run of frames.
struct Shot {
  std::size_t first = 0, count = 0;
};

/// The shot a reconstruction is of; empty when that is the whole clip.
std::optional<Shot> reconstructed_shot(const SfmResult& sfm);

/// The reconstruction as if the clip were that shot alone.
SfmResult of_shot(SfmResult sfm, const Shot& shot);

/// Puts the geometry of a shot into its place in the clip `frames`. The frames of other shots get the shot's nearest
/// camera, no foreground, and the layered prior for depth, at the shot's scale: an assumption that says so by its
/// confidence. Their "other_shots" is added to the facts.
void spread_over_clip(const Shot& shot, std::span<const ImageRgb> frames, ThreadPool& pool, Monitor& monitor,
                      EstimatedGeometry& geometry);

}  // namespace uwv::pipeline
