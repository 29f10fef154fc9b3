// SPDX-License-Identifier: Apache-2.0
// Rotary positions of a grid of tokens. Sheet model.md, 3.1.
#pragma once

#include <ATen/core/Tensor.h>

#include "model/transformer/transformer_config.h"

namespace uwv::model {

/// Cosine and sine of each token's and channel pair's angle, (tokens, head_dim / 2), float32 rounded from float64.
/// Pairs come in the order frame, row, column; tokens with the column fastest. Any size of grid is possible; the
/// published models have seen at most 21 frames, 45 rows and 80 columns.
struct RotaryTables {
  at::Tensor cosine, sine;
};

RotaryTables rotary_tables(const TokenGrid& grid, int head_dim, c10::Device device = c10::kCPU);

}  // namespace uwv::model
