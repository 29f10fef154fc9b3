// SPDX-License-Identifier: Apache-2.0
// The official bilinear soft-z splat on the CPU (geometry sheet, section 5.1).
#pragma once

#include <vector>

#include "uwv/render/rasterizer.h"

namespace uwv::detail {

/// A projected point on the reference's canvas, which is the target with one pixel of padding on each side and integer
/// pixel centres; weight 0 = draws nothing.
struct SoftPoint {
  float x = 0, y = 0, depth = 0, weight = 0;
};

/// Weighted sums of one target pixel.
struct SoftSum {
  float r = 0, g = 0, b = 0, depth = 0, weight = 0;
};

/// Memory kept between calls.
struct SoftScratch {
  Image<SoftPoint> points;
  Image<SoftSum> sums;
};

void soft_splat(const PointGrid& points, const ImageRgbF* colour, const Camera& target, const SoftSplatOptions& options,
                ThreadPool& pool, SoftScratch& scratch, SoftSplat& out);

}  // namespace uwv::detail
