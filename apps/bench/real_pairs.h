// SPDX-License-Identifier: Apache-2.0
// Real pictures with measured depth, each with a second real picture of the same scene from another camera.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "uwv/core/camera.h"
#include "uwv/io/resize_policy.h"

namespace uwv::bench {

/// A source picture with depth and what a second camera really saw, all at one working size.
struct RealPair {
  std::string name;
  Camera source;
  ImageRgb colour;
  DepthMap depth;            ///< 0 = not measured.
  std::vector<Camera> path;  ///< From the source to the second camera, which comes last.
  ImageRgb truth;            ///< The second camera's picture.
  DepthMap truth_depth;      ///< Its depth in the same unit; empty where there is none.
};

/// The motorcycle of stereo_pairs.h, with a path of eight steps. Throws Error when one of the files is missing.
RealPair motorcycle_pair(const std::string& folder, const ResizePolicy& resize);

/// Pairs of frames (source, target) of a still scene, from a folder read_true_clip() reads. The path of a pair is that
/// of the frames between. Throws Error when the folder holds something else or fewer frames than a pair asks for.
std::vector<RealPair> rgbd_pairs(const std::string& folder, const std::vector<std::pair<long, long>>& pairs,
                                 const ResizePolicy& resize);

}  // namespace uwv::bench
