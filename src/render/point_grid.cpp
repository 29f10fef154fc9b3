// SPDX-License-Identifier: Apache-2.0
#include "uwv/render/point_grid.h"

#include <cmath>

namespace uwv {
namespace {

std::array<std::array<float, 3>, 3> rounded(const Eigen::Matrix3d& m) {
  std::array<std::array<float, 3>, 3> out{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      out[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] = static_cast<float>(m(i, j));
  return out;
}

std::array<float, 3> rounded(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

}  // namespace

void PointGrid::check() const {
  require(depth != nullptr, "a point grid needs a depth map");
  const Size size = camera.size;
  require(size.width > 0 && size.height > 0 && size.width <= 65535 && size.height <= 65535,
          "a point grid of {}x{} pixels is outside 1..65535 on a side", size.width, size.height);
  require(depth->size() == size, "the depth map is {}x{}, its camera {}x{}", depth->width(), depth->height(),
          size.width, size.height);
  require(slopes == nullptr || slopes->size() == size, "the slope map does not have the depth map's size {}x{}",
          size.width, size.height);
  require(keep == nullptr || keep->size() == size, "the keep mask does not have the depth map's size {}x{}", size.width,
          size.height);
  require(cells == nullptr || cells->size() == size, "the map of cells does not have the depth map's size {}x{}",
          size.width, size.height);
  const Intrinsics& k = camera.intrinsics;
  require(std::isfinite(k.fx) && std::isfinite(k.fy) && k.fx != 0 && k.fy != 0 && std::isfinite(k.cx) &&
              std::isfinite(k.cy),
          "intrinsics fx={} fy={} cx={} cy={} cannot be inverted", k.fx, k.fy, k.cx, k.cy);
}

WarpMap WarpMap::between(const Camera& source, const Camera& target) {
  WarpMap map;
  const Rigid3 motion = target_from_source(target, source);
  const bool same_intrinsics = target.intrinsics == source.intrinsics;
  const bool no_rotation = motion.rotation == Eigen::Matrix3d::Identity();
  // The product K I K^-1 would miss the identity by rounding; a camera that only moves must not resample.
  const Eigen::Matrix3d a =
      same_intrinsics && no_rotation
          ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
          : Eigen::Matrix3d(target.intrinsics.matrix() * motion.rotation * source.intrinsics.inverse_matrix());
  const Eigen::Vector3d b = target.intrinsics.matrix() * motion.translation;
  const Eigen::Matrix3d back = same_intrinsics && no_rotation
                                   ? a
                                   : Eigen::Matrix3d(source.intrinsics.matrix() * motion.rotation.transpose() *
                                                     target.intrinsics.inverse_matrix());
  Eigen::Matrix3d folded = a;
  folded.col(2) += 0.5 * (a.col(0) + a.col(1));
  map.a = rounded(folded);
  map.b = rounded(b);
  map.a_inverse = rounded(back);
  map.k = rounded(Eigen::Vector3d(back * b));
  map.no_translation = motion.translation.isZero(0);
  map.identity = map.no_translation && no_rotation && same_intrinsics && source.size == target.size;
  return map;
}

}  // namespace uwv
