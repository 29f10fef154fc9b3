// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/colour_correction.h"

#include <Eigen/QR>

#include <algorithm>

namespace uwv::model {

Rgb8 ColourMap::operator()(const Eigen::Vector3d& colour) const {
  const Eigen::Vector3d mapped = matrix * colour + offset;
  const auto channel = [&](int c) { return static_cast<std::uint8_t>(std::clamp(mapped[c], 0.0, 255.0)); };
  return {channel(0), channel(1), channel(2)};
}

ColourMap fit_colours(const ImageFloat3& generated, const ImageRgb& wanted, const ValidityMask& known) {
  require(generated.size() == wanted.size() && known.size() == wanted.size(),
          "colours of {}x{} pixels cannot be fitted to {}x{}", generated.width(), generated.height(), wanted.width(),
          wanted.height());
  Eigen::Matrix4d squares = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 4, 3> products = Eigen::Matrix<double, 4, 3>::Zero();
  for (std::size_t i = 0; i < wanted.size().pixels(); ++i) {
    if (known.data()[i] == 0) continue;
    const Eigen::Vector3f& from = generated.data()[i];
    const Rgb8 to = wanted.data()[i];
    const Eigen::Vector4d row(from[0], from[1], from[2], 1);
    squares += row * row.transpose();
    products += row * Eigen::RowVector3d(to.r, to.g, to.b);
  }
  const Eigen::Matrix<double, 4, 3> solution = squares.completeOrthogonalDecomposition().solve(products);
  return {solution.topRows<3>().transpose(), solution.row(3).transpose()};
}

}  // namespace uwv::model
