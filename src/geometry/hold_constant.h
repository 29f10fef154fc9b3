// SPDX-License-Identifier: Apache-2.0
// Keeps some numbers of a parameter block fixed, in the words of whichever Ceres is there: 2.1 renamed what does it,
// and Ubuntu 22.04 has 2.0.
#pragma once

#include <ceres/problem.h>
#include <ceres/version.h>

#include <vector>
#if CERES_VERSION_MAJOR > 2 || (CERES_VERSION_MAJOR == 2 && CERES_VERSION_MINOR >= 1)
#include <ceres/manifold.h>
#else
#include <ceres/local_parameterization.h>
#endif

namespace uwv {

inline void hold_constant(ceres::Problem& problem, double* block, int size, const std::vector<int>& which) {
#if CERES_VERSION_MAJOR > 2 || (CERES_VERSION_MAJOR == 2 && CERES_VERSION_MINOR >= 1)
  problem.SetManifold(block, new ceres::SubsetManifold(size, which));
#else
  problem.SetParameterization(block, new ceres::SubsetParameterization(size, which));
#endif
}

}  // namespace uwv
