// SPDX-License-Identifier: Apache-2.0
// The official bilinear soft-z splat on the CPU (geometry sheet, section 5.1).
#pragma once

#include <vector>

#include "uwv/render/rasterizer.h"

namespace uwv::detail {

/// The points on the reference's canvas, which is the target with one pixel of padding on each side and integer pixel
/// centres. Weight 0 = draws nothing.
struct SoftPoints {
  Image<float> x, y, depth, weight;
  std::vector<float> top, bottom;  ///< Least and greatest y of each row's points; top > bottom where none draws.
  void resize(Size size);
};

/// Weighted sums of one canvas pixel, with colour and without.
struct alignas(32) ColourSum {
  using Value = float __attribute__((vector_size(16)));  ///< Red, green, blue, depth.
  Value value;
  float weight;
};
struct DepthSum {
  using Value = float;
  Value value;
  float weight;
};

/// Memory kept between calls.
struct SoftScratch {
  SoftPoints points;
  std::vector<ColourSum, CacheAligned<ColourSum>> colour_sums;
  std::vector<DepthSum, CacheAligned<DepthSum>> depth_sums;
};

void soft_splat(const PointGrid& points, const ImageRgbF* colour, const Camera& target, const SoftSplatOptions& options,
                ThreadPool& pool, SoftScratch& scratch, SoftSplat& out);

}  // namespace uwv::detail
