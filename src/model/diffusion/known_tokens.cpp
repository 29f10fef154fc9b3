// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/known_tokens.h"

#include <ATen/ATen.h>

#include <algorithm>
#include <array>

#include "uwv/core/error.h"

namespace uwv::model {

at::Tensor near_unknown(const at::Tensor& unknown, std::int64_t margin) {
  require(unknown.dim() == 3 && margin >= 0,
          "tokens have {} dimensions, wanted 3, and the margin is {}, wanted 0 or more", unknown.dim(), margin);
  at::Tensor near = unknown.to(at::kFloat).unsqueeze(0).unsqueeze(0);
  // A box is the same axis by axis, at a fraction of the work.
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::array<std::int64_t, 3> padding{0, 0, 0}, window{1, 1, 1};
    padding[axis] = std::min(margin, unknown.size(static_cast<std::int64_t>(axis)));
    window[axis] = 2 * padding[axis] + 1;
    near = at::max_pool3d(near, window, {1, 1, 1}, padding);
  }
  return near[0][0].gt(0);
}

at::Tensor places_of(const at::Tensor& tokens) { return tokens.flatten().nonzero().squeeze(1); }

at::Tensor latents_of_tokens(const at::Tensor& tokens) {
  return tokens.repeat_interleave(2, 1).repeat_interleave(2, 2).unsqueeze(0).unsqueeze(0);
}

}  // namespace uwv::model
