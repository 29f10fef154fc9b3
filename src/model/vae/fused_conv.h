// SPDX-License-Identifier: Apache-2.0
// Convolutions whose answer is added to what is there, without a picture in between. torch has them for its compiler;
// where this torch lacks them, and off the CPU, plain convolutions do the same. Weights stay as they are: laying them
// out for oneDNN takes a hundredth of a convolution's time, and ready-made layouts were slower where they were not the
// best ones.
#pragma once

#include <ATen/core/Tensor.h>

namespace uwv::model::fused_conv {

/// Rows of zeros above and below, columns of zeros left and right, and the stride both ways.
struct Steps {
  std::int64_t rows = 0, columns = 0, stride = 1;
};

/// `weight` (O, C, k, k), channels last. x (1, C, H, W), channels last -> (1, O, H', W'), channels last. `bias` (O) or
/// undefined.
at::Tensor run(const at::Tensor& x, const at::Tensor& weight, const at::Tensor& bias, const Steps& steps);
/// sum += run(x, ...); sum (1, O, H', W'), channels last.
void add(at::Tensor& sum, const at::Tensor& x, const at::Tensor& weight, const at::Tensor& bias, const Steps& steps);

}  // namespace uwv::model::fused_conv
