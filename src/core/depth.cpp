// SPDX-License-Identifier: Apache-2.0
#include "uwv/core/depth.h"

#include <algorithm>

namespace uwv {

std::size_t sanitize_depth(DepthMap& depth) {
  std::size_t changed = 0;
  for (float& z : depth.pixels()) {
    if (is_valid_depth(z)) continue;
    changed += z != 0.0F;  // NaN compares unequal and is counted
    z = 0.0F;
  }
  return changed;
}

float median_depth(const DepthMap& depth) {
  std::vector<float> valid;
  valid.reserve(depth.size().pixels());
  std::copy_if(depth.pixels().begin(), depth.pixels().end(), std::back_inserter(valid), is_valid_depth);
  if (valid.empty()) return 0.0F;
  const auto middle = valid.begin() + static_cast<std::ptrdiff_t>((valid.size() - 1) / 2);
  std::nth_element(valid.begin(), middle, valid.end());
  return *middle;
}

}  // namespace uwv
