// SPDX-License-Identifier: Apache-2.0
// One line through samples, by Ceres.
#pragma once

#include "geometry/alignment/samples.h"

namespace uwv::alignment {

/// Where a loss starts to bend, as a share of a sample's unit.
struct Loss {
  AlignmentLoss kind = AlignmentLoss::squared;
  double scale = 1;
};

/// Minimises sum weight * rho(residual), residuals being relative unless the loss is squared, from the line given;
/// `moments` are those of the samples and must not be singular. `shift` false keeps it at 0. Returns false when the
/// solver gave up or its answer is not finite.
bool fit_line(const Samples& samples, const Moments& moments, const Loss& loss, bool shift, AlignmentLine& line);

/// What a sample's weight is multiplied by at the solution: the derivative of rho at its relative residual.
double robust_weight(const Loss& loss, double relative_residual);

}  // namespace uwv::alignment
