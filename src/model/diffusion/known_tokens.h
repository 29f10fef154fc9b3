// SPDX-License-Identifier: Apache-2.0
// Which tokens need no network, because the rendering shows all of them and nothing near them is missing.
//
// Tokens left out are missing to the others' attention as well, so that this is an approximation: docs/performance.md
// has what it was measured to cost.
#pragma once

#include <ATen/core/Tensor.h>

namespace uwv::model {

/// Of tokens `unknown` (latent frames, rows, columns; bool) those at most `margin` frames, rows and columns away from
/// an unknown one: same shape.
at::Tensor near_unknown(const at::Tensor& unknown, std::int64_t margin);

/// Places of the true ones in their order, (count) int64.
at::Tensor places_of(const at::Tensor& tokens);

/// Each token's value for its 2x2 latents: (frames, rows, columns) to (1, 1, frames, 2 rows, 2 columns).
at::Tensor latents_of_tokens(const at::Tensor& tokens);

}  // namespace uwv::model
