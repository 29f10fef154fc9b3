// SPDX-License-Identifier: Apache-2.0
// Comparing a depth claimed in one view with the depth another view has at that place.
#pragma once

#include "geometry/mvs/view.h"

namespace uwv::mvs {

/// Pixel (centres at +0.5) and inverse depth w of one view to a homogeneous pixel of another, whose third component is
/// the ratio of depths: pixel_from_pixel * (x, y, 1) + w * shift.
struct Reprojection {
  Eigen::Matrix3f pixel_from_pixel;
  Eigen::Vector3f shift;
};
Reprojection make_reprojection(const Camera& from, const Camera& to);

/// What the other view's depth says this pixel's inverse depth is; 0 = it is unknown there, or differs by more than
/// `tolerance` relatively.
float agreed_inverse_depth(const Reprojection& to_other, const InverseDepthMap& other, float x, float y, float w,
                           float tolerance);

}  // namespace uwv::mvs
