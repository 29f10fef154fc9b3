// SPDX-License-Identifier: Apache-2.0
// token_kernels.h in torch's own operators, for tensors that lie elsewhere than on the CPU; the kernels come here by
// themselves. Same arguments, same answers to rounding, more passes over memory.
#pragma once

#include <ATen/core/Tensor.h>

#include <utility>

namespace uwv::model::formula {

at::Tensor layer_norm(const at::Tensor& x, const at::Tensor& scale, const at::Tensor& shift, double eps,
                      at::ScalarType type);
void add_gated(const at::Tensor& x, const at::Tensor& y, const at::Tensor& gate);
void rms_norm_rotate(const at::Tensor& x, const at::Tensor& weight, double eps, const at::Tensor& cosine,
                     const at::Tensor& sine);
std::pair<at::Tensor, at::Tensor> quantise_rows(const at::Tensor& x);
void scale_rows(const at::Tensor& y, const at::Tensor& scales, const at::Tensor& bias);
bool all_finite(const at::Tensor& x);

}  // namespace uwv::model::formula
