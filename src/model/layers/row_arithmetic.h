// SPDX-License-Identifier: Apache-2.0
// The arithmetic of token_kernels.h on one row of numbers.
#pragma once

#include <cstddef>
#include <cstdint>

namespace uwv::model::row {

/// bfloat16 is the upper half of a float32.
void widen(const std::uint16_t* from, std::size_t n, float* to);
/// Rounds to nearest, ties to even.
void narrow(const float* from, std::size_t n, std::uint16_t* to);

float mean(const float* x, std::size_t n);
/// Mean of (x - centre)^2.
float mean_square(const float* x, std::size_t n, float centre);
float largest(const float* x, std::size_t n);

/// (x - centre) * factor * scale + shift.
void modulate(const float* x, std::size_t n, float centre, float factor, const float* scale, const float* shift,
              float* to);
/// x * factor * weight in place.
void scale_by(float* x, std::size_t n, float factor, const float* weight);
/// x = x * factor + bias in place.
void scale_and_add(float* x, std::size_t n, float factor, const float* bias);
/// x += y * gate in place.
void add_product(float* x, const float* y, const float* gate, std::size_t n);
/// x += y in place.
void add(float* x, const float* y, std::size_t n);
/// Turns `pairs` pairs of neighbouring values in place.
void rotate(float* x, std::size_t pairs, const float* cosine, const float* sine);
/// Nearest whole number of x * factor, which lies within -127..127.
void round_to_i8(const float* x, std::size_t n, float factor, std::int8_t* to);

}  // namespace uwv::model::row
