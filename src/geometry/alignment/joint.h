// SPDX-License-Identifier: Apache-2.0
// All frames' lines at once.
#pragma once

#include "geometry/alignment/frame_fit.h"

namespace uwv::alignment {

/// Minimises, over the lines l_i of all frames, with L = smooth_frames,
///     sum_i share_i * mean over i's samples of residual^2
///       + L^4 * sum_i |l_(i-1) - 2 l_i + l_(i+1)|^2  +  (L / 5)^2 * sum_i |l_(i+1) - l_i|^2,
/// lines measured by how far they move the clip's samples apart, share_i = 1 for a frame with the usual number of
/// samples and less for one with fewer. Losses enter as the weights they gave the samples. A lone first difference
/// would flatten every drift: at the same noise it errs two to three times as much on clips that drift. False when all
/// frames together determine no line.
bool solve_jointly(const std::vector<FrameFit>& fits, const AlignmentOptions& options,
                   std::vector<AlignmentLine>& lines);

}  // namespace uwv::alignment
