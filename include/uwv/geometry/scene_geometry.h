// SPDX-License-Identifier: Apache-2.0
// What a clip's geometry is, wherever it came from: depth, cameras and how far each can be trusted.
//
// Providers (structure from motion, networks, the layered prior, files) all deliver this, so that nothing after them
// needs to know which one spoke. Design: docs/geometry.md.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "uwv/core/camera.h"
#include "uwv/core/image.h"
#include "uwv/geometry/slopes.h"

namespace uwv {

/// Who says how deep the scene is and where the cameras were.
enum class GeometryProvider {
  import,   ///< Files the user gave.
  network,  ///< A depth network exported to TorchScript.
  sfm,      ///< Structure from motion, then multi-view stereo: real, known up to one scale.
  prior,    ///< Layers standing on a ground plane: an assumption, not a measurement.
};
std::string_view to_string(GeometryProvider provider);

/// How much a depth is worth, 0 (a guess, or nothing there) to 1 (measured and confirmed by other views). Same size as
/// the depth it belongs to. From 0.5 on it is a measurement; below, an interpolation or a prior.
using ConfidenceMap = Image<float>;

/// One frame's geometry. Depth is in the same unit as the cameras' translations.
struct FrameGeometry {
  DepthMap depth;            ///< 0 = unknown.
  ConfidenceMap confidence;  ///< 0 where depth is 0.
};

/// A clip's geometry; all frames have the same size.
struct SceneGeometry {
  std::vector<FrameGeometry> frames;
  std::vector<Camera> cameras;  ///< One per frame, sized as the depth.
  /// One per frame, unit length, in the camera's frame and facing it; zero where unknown. Empty: nobody gave any, and
  /// surfaces follow from the depth.
  std::vector<NormalMap> normals;
  GeometryProvider depth_from = GeometryProvider::prior;
  GeometryProvider cameras_from = GeometryProvider::prior;
  std::vector<std::string> notes;  ///< One sentence each: what was decided and why, what is uncertain.
};

}  // namespace uwv
