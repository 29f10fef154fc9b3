// SPDX-License-Identifier: Apache-2.0
// What other views' depths say about a view's depth.
#pragma once

#include <vector>

#include "geometry/mvs/semi_global.h"

namespace uwv::mvs {

/// A view's depth with what it is worth (scene_geometry.h: 0.5 and more = confirmed by another view).
struct RatedDepth {
  InverseDepthMap inverse_depth;
  Image<float> confidence;
};

struct MatchedView {
  const View* view = nullptr;
  const MatchedDepth* depth = nullptr;
};

/// Keeps what at least one of the others confirms: its depth where the pixel lands differs by no more than `tolerance`,
/// relatively. Kept depths become the mean over the views that agree, which halves the noise of four. Confidence grows
/// with the number that agree and with distinctness; depths that are not distinct are not kept, because even pictures
/// agree about anything.
RatedDepth confirm(const MatchedView& reference, const std::vector<MatchedView>& others, double tolerance);

/// Unsets connected patches of less than `smallest` pixels that stand out from their surroundings by more than
/// `tolerance`.
void remove_speckles(RatedDepth& depth, int smallest, double tolerance);

}  // namespace uwv::mvs
