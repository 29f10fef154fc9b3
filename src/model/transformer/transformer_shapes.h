// SPDX-License-Identifier: Apache-2.0
// The weights a transformer wants, by diffusers' names. Sheet model.md, 2.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "model/transformer/transformer_config.h"

namespace uwv::model {

/// Names with shapes. Both reference branches have the same names: reference attention j is "uniview_ref_attn.<j>.*"
/// and its gate is value j of "uniview_ref_gates".
std::map<std::string, std::vector<std::int64_t>> transformer_shapes(const TransformerConfig& config);

}  // namespace uwv::model
