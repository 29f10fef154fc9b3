// SPDX-License-Identifier: Apache-2.0
// Incremental reconstruction (Schoenberger & Frahm 2016): start from two views, add cameras and points, adjust.
#pragma once

#include "geometry/sfm/bundle_adjustment.h"
#include "geometry/sfm/two_view.h"
#include "uwv/core/thread_pool.h"

namespace uwv::sfm {

struct GrowOptions {
  double max_error_px = 2;
  bool refine_focal = false;
  double focal_prior = 0;
  std::uint64_t seed = 1;
};

/// The two cameras of `start` and the points both see, adjusted.
Reconstruction begin(const std::vector<Track>& tracks, int frames, const Intrinsics& lens, const TwoViewStart& start,
                     const GrowOptions& options);
/// Adds those keyframes that have no camera yet, and points, adjusting on the way and at the end. Frames that do not
/// fit are left without a pose.
void grow(Reconstruction& reconstruction, const std::vector<Track>& tracks, std::span<const int> keyframes,
          const GrowOptions& options);
/// What is there adjusted together, outliers dropped.
void settle(Reconstruction& reconstruction, const std::vector<Track>& tracks, const GrowOptions& options);
/// Poses for all frames without one, each by itself from the points there are. Nothing else moves.
void place_others(Reconstruction& reconstruction, const std::vector<Track>& tracks, double max_error_px,
                  std::uint64_t seed, ThreadPool& pool);

/// Mean over the keyframes' observations of the squared error, cut off at max_error^2; observations that nothing
/// explains count fully. Comparable between reconstructions of the same tracks; smaller is better.
double misfit(const Reconstruction& reconstruction, const std::vector<Track>& tracks, std::span<const int> keyframes,
              double max_error_px);

}  // namespace uwv::sfm
