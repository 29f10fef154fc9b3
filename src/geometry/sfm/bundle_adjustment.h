// SPDX-License-Identifier: Apache-2.0
// Cameras, points and, where asked, the focal length, adjusted together by Ceres until the points land where they were
// seen.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "geometry/sfm/feature_tracks.h"
#include "uwv/core/camera.h"

namespace uwv::sfm {

/// A reconstruction under way: camera poses by frame, points by track.
struct Model {
  Intrinsics intrinsics;  ///< Of every frame.
  std::map<int, Rigid3> cam_from_world;
  std::vector<Eigen::Vector3d> points;
  std::vector<std::uint8_t> known;  ///< Per track: 1 = points holds it.
};

struct AdjustOptions {
  bool focal = false;           ///< Also adjust one focal length (fx = fy kept in proportion).
  double prior_focal = 0;       ///< It is held near this, weakly; 0 = not at all.
  int iterations = 20;
  int threads = 1;
  double loss_px = 1;           ///< Cauchy: observations farther off than this count less and less.
};

/// Improves `model` in place. The first frame's pose stays where it is.
void adjust(const std::vector<Track>& tracks, const AdjustOptions& options, Model& model);

/// How far, in pixels, a known point lands from where it was seen; negative when it is behind the camera.
double reprojection_error(const Model& model, const Track& track, std::size_t index, int frame);

}  // namespace uwv::sfm
