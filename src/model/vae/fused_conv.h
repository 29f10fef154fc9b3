// SPDX-License-Identifier: Apache-2.0
// Convolution as oneDNN does it best: weights laid out for it once, and answers added to what is there without a
// picture in between. torch has both for its compiler; where this torch lacks them, plain convolutions do the same.
#pragma once

#include <ATen/core/Tensor.h>

namespace uwv::model::fused_conv {

/// `weight` (O, C, k, k) in the layout that the calls below want. Zeros all around: `padding` on each side.
at::Tensor packed(const at::Tensor& weight, std::int64_t padding, std::int64_t stride);

/// x (1, C, H, W), channels last -> (1, O, H', W'), channels last. `bias` (O) or undefined.
at::Tensor run(const at::Tensor& x, const at::Tensor& weight, const at::Tensor& bias, std::int64_t padding,
               std::int64_t stride);
/// sum += run(x, ...); sum (1, O, H', W'), channels last.
void add(at::Tensor& sum, const at::Tensor& x, const at::Tensor& weight, const at::Tensor& bias, std::int64_t padding,
         std::int64_t stride);

}  // namespace uwv::model::fused_conv
