// SPDX-License-Identifier: Apache-2.0
#include "shape.h"

#include <cmath>
#include <limits>

namespace uwv {
namespace {

ShapeCrossings cross(const Plate& plate, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  if (direction.z() == 0) return {};
  const double t = -origin.z() / direction.z();
  const bool inside = std::abs(origin.x() + t * direction.x()) <= plate.half_width &&
                      std::abs(origin.y() + t * direction.y()) <= plate.half_height;
  return inside ? ShapeCrossings{1, {t, 0}} : ShapeCrossings{};
}

ShapeCrossings cross(const Box& box, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  double enter = -std::numeric_limits<double>::infinity();
  double leave = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    if (direction[i] == 0) {
      if (std::abs(origin[i]) > box.half[i]) return {};
      continue;
    }
    const double a = (-box.half[i] - origin[i]) / direction[i];
    const double b = (box.half[i] - origin[i]) / direction[i];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave ? ShapeCrossings{2, {enter, leave}} : ShapeCrossings{};
}

// By the ray's nearest point to the centre: the textbook discriminant b^2 - ac loses all digits for a far, small ball.
ShapeCrossings cross(const Sphere& sphere, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  const double squared = direction.squaredNorm();
  const double middle = -origin.dot(direction) / squared;
  const double gap = sphere.radius * sphere.radius - (origin + middle * direction).squaredNorm();
  if (gap < 0) return {};
  const double half_chord = std::sqrt(gap / squared);
  return {2, {middle - half_chord, middle + half_chord}};
}

SurfacePoint surface_point(const Plate&, const Eigen::Vector3d& x) {
  return {Eigen::Vector3d::UnitZ(), {x.x(), x.y(), 0.0}};
}

SurfacePoint surface_point(const Box& box, const Eigen::Vector3d& x) {
  Eigen::Index axis = 0;
  x.cwiseAbs().cwiseQuotient(box.half).maxCoeff(&axis);
  const double side = x[axis] < 0 ? -1.0 : 1.0;
  const double shift = 4.3 * box.half.maxCoeff() * (2.0 * static_cast<double>(axis) + (side < 0 ? 1 : 0));
  return {side * Eigen::Vector3d::Unit(axis), {x[(axis + 1) % 3] + shift, x[(axis + 2) % 3], 0.0}};
}

SurfacePoint surface_point(const Sphere&, const Eigen::Vector3d& x) { return {x.normalized(), x}; }

}  // namespace

ShapeCrossings cross(const Shape& shape, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  return std::visit([&](const auto& s) { return cross(s, origin, direction); }, shape);
}

SurfacePoint surface_point(const Shape& shape, const Eigen::Vector3d& x) {
  return std::visit([&](const auto& s) { return surface_point(s, x); }, shape);
}

}  // namespace uwv
