// SPDX-License-Identifier: Apache-2.0
// Products of matrices of 8-bit whole numbers.
#pragma once

#include <ATen/core/Tensor.h>

namespace uwv::model {

/// The weight (out, in; int8) laid out for int8_product; opaque.
at::Tensor pack_int8(const at::Tensor& weight);

/// Tokens (rows, in; int8) as int8_product takes them, in place of the numbers given.
at::Tensor int8_tokens(const at::Tensor& numbers);

/// x (rows, in), of int8_tokens(), times the packed weight, each output channel times its scale (float32, out), as
/// `type` (float32 or bfloat16): (rows, out). Sums are exact.
at::Tensor int8_product(const at::Tensor& x, const at::Tensor& packed, const at::Tensor& scales, at::ScalarType type);

/// False where the CPU adds pairs of products in 16 bits, which overflow (AVX2 without VNNI): sums of large numbers
/// then come out too small. Tried out once.
bool int8_product_is_exact();

}  // namespace uwv::model
