// SPDX-License-Identifier: Apache-2.0
// Semi-global aggregation of matching costs (Hirschmueller, PAMI 2008) and the choice of a depth per pixel.
#pragma once

#include "geometry/mvs/plane_sweep.h"

namespace uwv::mvs {

struct MatchedDepth {
  InverseDepthMap inverse_depth;  ///< Of the best plane, refined between planes; 0 where nothing told planes apart.
  Image<float> distinctness;      ///< 0..1: by how much the best plane beats the best that is not beside it.
  Image<float> cost;              ///< 0..1: what the best plane itself costs, before aggregation.
};

/// Costs summed over eight paths through the picture, along which a step to the next plane costs little and a jump
/// costs much, less where the picture has an edge. `sums` is scratch, reused from frame to frame.
void aggregate(const CostVolume& volume, const Image<float>& grey, std::vector<std::uint16_t>& sums, MatchedDepth& out);

}  // namespace uwv::mvs
