// SPDX-License-Identifier: Apache-2.0
// What a network's outputs say of each frame, in the terms of the library.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/depth_manifest.h"
#include "model/map_resize.h"
#include "model/network_output.h"
#include "uwv/core/camera.h"

namespace uwv::model {

/// Maps have the size the network gave them; cameras are in pixels of the frame.
struct FrameReading {
  KnownMap depth;
  VectorMap normals;
  std::optional<Intrinsics> intrinsics;
  std::optional<Rigid3> world_from_cam;
  std::size_t not_finite = 0;  ///< Pixels that were NaN or infinite though the network's own mask, if any, kept them.
  bool shift_unknown = false;  ///< The points say nothing of the depth shift.
};

struct ReadingContext {
  Size frame;
  Size input;  ///< What the network saw.
  float plain_confidence;
  const std::string& model_path;
};

/// One reading per frame of the call.
std::vector<FrameReading> read_output(const DepthManifest& manifest, const NetworkOutput& output,
                                      const ReadingContext& context);

}  // namespace uwv::model
