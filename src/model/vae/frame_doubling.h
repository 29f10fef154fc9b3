// SPDX-License-Identifier: Apache-2.0
// A frame at twice its size.
#pragma once

#include <ATen/core/Tensor.h>

namespace uwv::model {

/// (H, W, C) -> (2H, 2W, C), contiguous: each pixel becomes 2x2.
inline at::Tensor doubled(const at::Tensor& frame) {
  const std::int64_t height = frame.size(0), width = frame.size(1), channels = frame.size(2);
  return frame.unsqueeze(1)
      .unsqueeze(3)
      .expand({height, 2, width, 2, channels})
      .reshape({2 * height, 2 * width, channels});
}

/// The same into `out`, contiguous.
inline void double_into(const at::Tensor& frame, const at::Tensor& out) {
  const std::int64_t height = frame.size(0), width = frame.size(1), channels = frame.size(2);
  out.view({height, 2, width, 2, channels})
      .copy_(frame.unsqueeze(1).unsqueeze(3).expand({height, 2, width, 2, channels}));
}

}  // namespace uwv::model
