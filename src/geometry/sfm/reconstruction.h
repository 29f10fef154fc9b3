// SPDX-License-Identifier: Apache-2.0
// From tracks to cameras and points: a pair of frames starts, the others are resected into it one by one.
#pragma once

#include <optional>
#include <vector>

#include "geometry/sfm/bundle_adjustment.h"
#include "geometry/sfm/motion_kind.h"
#include "uwv/core/monitor.h"

namespace uwv::sfm {

struct Reconstruction {
  Model model;
  double rms_px = 0;           ///< Over all inlier observations.
  std::size_t observations = 0;
};

/// Frames with enough motion between them to be worth reconstructing; first and last of the shot included.
std::vector<int> key_frames(const std::vector<double>& shift_px, const Shot& shot, double picture_width);

/// Reconstructs the key frames with the given lens as a start. Nothing when no pair of them starts it.
std::optional<Reconstruction> reconstruct(const std::vector<Track>& tracks, const std::vector<int>& keys,
                                          const Intrinsics& intrinsics, bool adjust_focal, const SfmOptions& options,
                                          int threads, Monitor& monitor);

/// Resects the shot's other frames and adjusts everything together.
void register_rest(const std::vector<Track>& tracks, const Shot& shot, bool adjust_focal, const SfmOptions& options,
                   int threads, Monitor& monitor, Reconstruction& reconstruction);

}  // namespace uwv::sfm
