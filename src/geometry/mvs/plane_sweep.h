// SPDX-License-Identifier: Apache-2.0
// How badly each depth hypothesis of each pixel matches the other views.
#pragma once

#include <vector>

#include "geometry/mvs/sweep_kernels.h"
#include "geometry/mvs/view.h"
#include "geometry/mvs/view_selection.h"

namespace uwv::mvs {

/// Costs [y][x][plane], bytes, 0 (same) to worst_cost. Rows of planes are padded with 255 to `padded` entries.
struct CostVolume {
  Size size;
  int planes = 0;
  int padded = 0;
  DepthRange range;
  std::vector<std::uint8_t, detail::CacheAligned<std::uint8_t>> costs;

  float inverse_depth(float plane) const {
    return planes < 2 ? range.farthest
                      : range.farthest + (range.nearest - range.farthest) * plane / static_cast<float>(planes - 1);
  }
  std::uint8_t* at(int x, int y) { return costs.data() + offset(x, y); }
  const std::uint8_t* at(int x, int y) const { return costs.data() + offset(x, y); }

 private:
  std::size_t offset(int x, int y) const {
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) + static_cast<std::size_t>(x)) *
           static_cast<std::size_t>(padded);
  }
};

/// Each other view is warped onto the reference over every plane parallel to the reference's picture and compared by
/// contrast and structure in small windows, which brightness does not change and exposure hardly. A pixel's cost is
/// the mean of the better half of the views: what hides a surface seldom does so from both sides.
void sweep_planes(const View& reference, const std::vector<const View*>& others, DepthRange range, int planes,
                  CostVolume& volume);

}  // namespace uwv::mvs
