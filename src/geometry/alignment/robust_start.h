// SPDX-License-Identifier: Apache-2.0
// A first line that wrong samples cannot pull away, for the losses that only find what they start near.
#pragma once

#include "geometry/alignment/line_fit.h"

namespace uwv::alignment {

/// Tries lines through `options.start_trials` random pairs of samples (single samples without a shift) and returns the
/// one most samples lie within `options.loss_scale` of. False when no pair gives a line: all samples at one x, or all
/// falling while falling lines are refused.
bool robust_start(const Samples& samples, const AlignmentOptions& options, std::uint64_t seed, AlignmentLine& line);

}  // namespace uwv::alignment
