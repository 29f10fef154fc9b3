// SPDX-License-Identifier: Apache-2.0
#include "model/float_tensor.h"

#include <fmt/format.h>

namespace uwv::model {

std::string shape_text(const std::vector<std::int64_t>& shape) { return fmt::format("[{}]", fmt::join(shape, ", ")); }

}  // namespace uwv::model
