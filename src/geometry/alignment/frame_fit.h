// SPDX-License-Identifier: Apache-2.0
// What one frame says by itself.
#pragma once

#include "geometry/alignment/line_fit.h"

namespace uwv::alignment {

struct FrameFit {
  FrameAlignment report;  ///< All but `line` and `usable`.
  Moments moments;        ///< Of the samples as they counted in the end, for solving frames jointly; weight 0 = none.
};

FrameFit fit_frame(const AlignmentFrame& frame, const AlignmentOptions& options, std::uint64_t index);

}  // namespace uwv::alignment
