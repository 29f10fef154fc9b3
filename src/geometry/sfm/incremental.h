// SPDX-License-Identifier: Apache-2.0
// Incremental reconstruction (Schoenberger & Frahm 2016): start from two views, add cameras and points, adjust.
#pragma once

#include "geometry/sfm/bundle_adjustment.h"
#include "geometry/sfm/two_view.h"

namespace uwv::sfm {

struct GrowOptions {
  double max_error_px = 2;
  bool refine_focal = false;
  double focal_prior = 0;
};

/// Cameras of the keyframes and points, grown from `start`. Frames that do not fit are left without a pose.
Reconstruction grow(const std::vector<Track>& tracks, int frames, std::span<const int> keyframes,
                    const Intrinsics& lens, const TwoViewStart& start, const GrowOptions& options);
/// Poses for the frames between, then everything adjusted together and outliers dropped.
void finish(Reconstruction& reconstruction, const std::vector<Track>& tracks, const GrowOptions& options);

/// Mean over the keyframes' observations of the squared error, cut off at max_error^2; observations that nothing
/// explains count fully. Comparable between reconstructions of the same tracks; smaller is better.
double misfit(const Reconstruction& reconstruction, const std::vector<Track>& tracks, std::span<const int> keyframes,
              double max_error_px);

}  // namespace uwv::sfm
