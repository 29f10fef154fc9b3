// SPDX-License-Identifier: Apache-2.0
#include "model/float_tensor.h"

#include <fmt/format.h>

namespace uwv::model {

std::string shape_text(const FloatTensor& tensor) { return fmt::format("[{}]", fmt::join(tensor.shape, ", ")); }

}  // namespace uwv::model
