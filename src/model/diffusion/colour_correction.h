// SPDX-License-Identifier: Apache-2.0
// Takes back the drift of colours that the network and its autoencoder bring in. Sheet geometry-and-rendering.md, 8.
//
// The first frame is known: it is the source picture. The affine map that takes the generated first frame to it, by
// least squares over all pixels, is applied to all frames.
#pragma once

#include <Eigen/Core>

#include "uwv/core/mask.h"

namespace uwv::model {

/// corrected = matrix * colour + offset, colours in 0..255.
struct ColourMap {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();

  /// Channels clipped to 0..255 and cut off to whole numbers, as the official code does.
  Rgb8 operator()(const Eigen::Vector3d& colour) const;
};

/// A picture of floats, 0..255, not rounded.
using ImageFloat3 = Image<Eigen::Vector3f>;

/// The best map from `generated` to `wanted` over the pixels that are `known` (the official code takes all, as its
/// first frame has no holes); of several the smallest, as a picture of one colour leaves many. Throws
/// std::invalid_argument when the sizes differ.
ColourMap fit_colours(const ImageFloat3& generated, const ImageRgb& wanted, const ValidityMask& known);

}  // namespace uwv::model
