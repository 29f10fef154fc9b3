// SPDX-License-Identifier: Apache-2.0
// manifest.json of a depth network. docs/depth-models.md is its reference.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/network_manifest.h"

namespace uwv::model {

enum class NetworkKind { metric_depth, inverse_depth, points, depth_and_pose };
enum class ConfidenceRule { unit, logit, from_one };

/// Windows over a clip, as Video Depth Anything has them (geometry sheet 4.5): each window begins with `overlap` frames
/// of the one before, taken at `keyframes`; the last `blend` of them are its last frames and are blended, the others
/// tie the windows' scale and shift together.
struct WindowRule {
  int frames = 0;
  int overlap = 0;
  int blend = 0;
  std::vector<int> keyframes;
  int step() const { return frames - overlap; }
  int tied() const { return overlap - blend; }
};

struct DepthManifest : NetworkManifest {
  NetworkKind kind = NetworkKind::metric_depth;
  bool metric = true;
  ConfidenceRule confidence_rule = ConfidenceRule::unit;
  bool mask_is_logit = false;
  double mask_threshold = 0.5;
  double max_depth = 0;  ///< Farther depths are unknown (a network's sky); 0 = none.
  bool pose_is_cam_from_world = true;
  bool one_field_of_view = false;
  std::optional<WindowRule> window;
};

/// Throws Error(file_not_found, file_damaged, value_invalid).
DepthManifest read_depth_manifest(const std::string& path);

}  // namespace uwv::model
