// SPDX-License-Identifier: Apache-2.0
// Small rules that every depth map obeys.
#pragma once

#include "uwv/core/image.h"

namespace uwv {

/// The largest depth we accept, in scene units; farther values are as good as "infinitely far" and become invalid. The
/// bound keeps z * 2^-40 inside (0, 1), which the GL renderer relies on for an exact depth test.
inline constexpr float max_depth = 1e12F;
/// The smallest positive depth we accept; smaller ones are denormal noise and become invalid.
inline constexpr float min_depth = 1e-12F;

inline bool is_valid_depth(float z) { return z >= min_depth && z <= max_depth; }  // false for NaN

/// Sets every value that is NaN, infinite, negative or outside [min_depth, max_depth] to 0 (invalid).
/// Returns how many values were changed (zeros not counted).
std::size_t sanitize_depth(DepthMap& depth);

/// The lower median of the valid depths, the reference's `depth_avg` (geometry sheet, section 1): the orbit radius.
/// 0 when no depth is valid.
float median_depth(const DepthMap& depth);

}  // namespace uwv
