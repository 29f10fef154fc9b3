// SPDX-License-Identifier: Apache-2.0
// Where rays cross the primitive shapes, in the shape's own frame.
#pragma once

#include <Eigen/Core>

#include <array>

#include "uwv/eval/synthetic_scene.h"

namespace uwv {

/// Up to two distances in ascending order, of any sign.
struct ShapeCrossings {
  std::size_t count = 0;
  std::array<double, 2> distance{};
};

ShapeCrossings cross(const Shape& shape, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction);

struct SurfacePoint {
  Eigen::Vector3d normal;  ///< Unit length, outward; a plate's is +z.
  Eigen::Vector3d x_in_texture;
};

/// `x` lies on the shape's surface but for rounding.
SurfacePoint surface_point(const Shape& shape, const Eigen::Vector3d& x);

}  // namespace uwv
