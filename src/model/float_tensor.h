// SPDX-License-Identifier: Apache-2.0
// Numbers on their way into a network and out of it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace uwv::model {

/// Row-major floats; values.size() is the product of `shape`.
struct FloatTensor {
  std::vector<std::int64_t> shape;
  std::vector<float> values;
};

/// As Python would print it, "[1, 3, 518, 518]".
std::string shape_text(const std::vector<std::int64_t>& shape);

}  // namespace uwv::model
