// SPDX-License-Identifier: Apache-2.0
// A frame as the matcher sees it: shrunk to the matching resolution, in a frame of reference in which floats suffice.
#pragma once

#include <span>
#include <vector>

#include "uwv/core/camera.h"
#include "uwv/core/image.h"
#include "uwv/core/mask.h"
#include "uwv/geometry/structure_from_motion.h"

namespace uwv::mvs {

/// Inverse depth in 1 / normalised units; 0 = unknown.
using InverseDepthMap = Image<float>;

struct View {
  Camera camera;      ///< At the matching size, normalised (see Normalisation).
  Image<float> grey;  ///< 0..255, centred on 0 so that sums of squares stay small.
  ImageRgb colour;
  Image<std::uint8_t> usable;  ///< 1 = static; empty = all are.
};

/// Moves the first camera's centre to the origin and makes the scene's typical depth 1: whatever the unit and wherever
/// the world's origin, the matcher sees the same numbers.
struct Normalisation {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double unit = 1;  ///< Scene units per normalised unit.

  Camera apply(const Camera& camera) const;
  Eigen::Vector3d apply(const Eigen::Vector3d& x_in_world) const { return (x_in_world - centre) / unit; }
};

/// The unit is the median depth of the points over the cameras that see them; without points, a multiple of the
/// cameras' typical distance from each other; 1 when there is neither.
Normalisation find_normalisation(std::span<const Camera> cameras, std::span<const ScenePoint> points);

/// `usable` may be empty (no pixel moves).
View make_view(const ImageRgb& frame, const Camera& normalised, const ValidityMask* usable, Size size);

/// The picture averaged over areas; `size` is not larger in either axis.
ImageRgb shrink(const ImageRgb& picture, Size size);

}  // namespace uwv::mvs
