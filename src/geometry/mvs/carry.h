// SPDX-License-Identifier: Apache-2.0
// Depth of a frame between two matched ones, from theirs.
#pragma once

#include <vector>

#include "geometry/mvs/consistency.h"

namespace uwv::mvs {

struct KeyDepth {
  const View* view = nullptr;
  const RatedDepth* depth = nullptr;
};

/// Moves every depth of the keys to where `target` sees it; the nearest surface wins. The moved depth is then looked up
/// in the keys again, which undoes the rounding to whole pixels and averages the keys. Confidence moves along.
RatedDepth carry(const View& target, const std::vector<KeyDepth>& keys, double tolerance);

}  // namespace uwv::mvs
