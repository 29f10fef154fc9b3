// SPDX-License-Identifier: Apache-2.0
// What a transformer does to each token by itself, each in one pass over memory: norms, gates, rotary positions and
// quantisation. Sheet model.md, 3 ("Block", "Attention").
//
// x is (batch, tokens, dim), contiguous, float32 or bfloat16; numbers are worked on as float32. A result depends on its
// own row only, so it has the same bits on any number of threads. Of tensors that lie elsewhere than on the CPU,
// token_formulas.h takes care.
#pragma once

#include <ATen/core/Tensor.h>

#include <utility>

namespace uwv::model {

/// (x - mean) / sqrt(variance + eps) * scale + shift over dim, as `type`. scale and shift are float32 (batch or 1,
/// dim).
at::Tensor layer_norm(const at::Tensor& x, const at::Tensor& scale, const at::Tensor& shift, double eps,
                      at::ScalarType type);

/// x += y * gate in place; x float32, gate float32 (batch or 1, dim) or undefined for 1.
void add_gated(const at::Tensor& x, const at::Tensor& y, const at::Tensor& gate);

/// In place: x / sqrt(mean of x^2 over dim + eps) * weight (float32, dim); then, where `cosine` and `sine` are given
/// ((tokens, head_dim / 2), float32), each pair of neighbouring channels of each head is turned by its angle.
void rms_norm_rotate(const at::Tensor& x, const at::Tensor& weight, double eps, const at::Tensor& cosine,
                     const at::Tensor& sine);

/// Whole numbers of -127..127 for x (rows, dim) with one scale a row, x ~ number * scale. An all-zero row gets scale 0.
std::pair<at::Tensor, at::Tensor> quantise_rows(const at::Tensor& x);

/// In place on y (rows, out): y * scales of the row + bias (float32, out; may be undefined).
void scale_rows(const at::Tensor& y, const at::Tensor& scales, const at::Tensor& bias);

/// Whether no value is NaN or infinite.
bool all_finite(const at::Tensor& x);

}  // namespace uwv::model
