// SPDX-License-Identifier: Apache-2.0
// A look at the scene before the work: what the wanted path asks of it, and so which parts of the method it needs.
#pragma once

#include <string>

#include "uwv/core/depth.h"
#include "uwv/geometry/reliability.h"
#include "uwv/trajectory/target_path.h"

namespace uwv {

/// Measured on source frame 0 along the whole path. "Pixels" are those of the working size.
struct SceneLook {
  double near_depth = 0;  ///< 5 % of the valid depths are nearer, scene units.
  double far_depth = 0;   ///< 5 % are farther.
  /// Some target camera stands elsewhere than the source camera of the same moment. Without that nothing can be
  /// occluded, and Algorithm 1 needs one pass.
  bool has_parallax = false;
  /// How far the pictures of the near and the far depth move apart: the largest over picture and path.
  double parallax_px = 0;
  /// The widest gap that opens between two neighbouring samples of the depth: the size of the holes to come.
  double disocclusion_px = 0;
  /// Pixels of the path that the points of the moment's frame leave open, mean over the path: what is uncovered, and
  /// what lies outside the source's picture. Drawn small.
  double uncovered_share = 0;
  double max_rotation_deg = 0;  ///< Between target and source camera of the same moment.
  double max_translation = 0;   ///< Likewise, in radii.
  long first_return = -1;       ///< First target frame at which the camera comes back towards the source; -1 = never.
  EdgeSharpness edges;          ///< Of the depth; decides the reliability filter where that is left to us.

  /// One line for people.
  std::string brief() const;
};

SceneLook look_at_scene(const DepthMap& depth, const TargetPath& path, const PathContext& context, ThreadPool& pool);

}  // namespace uwv
