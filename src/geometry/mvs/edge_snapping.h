// SPDX-License-Identifier: Apache-2.0
// Puts steps of depth where the picture has its edges.
#pragma once

#include "geometry/mvs/view.h"

namespace uwv::mvs {

/// Windows that straddle an outline match by the side with more contrast, whose depth so spreads a few pixels beyond
/// the outline. Pixels close to a step of depth take the depth that most of what is coloured like them around has (the
/// weighted median), if that is another surface than their own. Elsewhere nothing changes, nor where depth is unknown.
/// `colour` and the depth are of one size, or std::invalid_argument is thrown.
void snap_to_edges(const ImageRgb& colour, InverseDepthMap& inverse_depth);

}  // namespace uwv::mvs
