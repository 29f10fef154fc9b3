// SPDX-License-Identifier: Apache-2.0
#include "model/layers/row_arithmetic.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "uwv/core/simd.h"

namespace uwv::model::row {
namespace {

/// Sums are kept in so many lanes, so that the compiler may add several at once without changing their order.
constexpr std::size_t lanes = 16;

float sum_of(const float (&sums)[lanes]) {
  float total = 0;
  for (const float sum : sums) total += sum;
  return total;
}

}  // namespace

UWV_SIMD_CLONES
void widen(const std::uint16_t* from, std::size_t n, float* to) {
  for (std::size_t i = 0; i < n; ++i) to[i] = std::bit_cast<float>(static_cast<std::uint32_t>(from[i]) << 16);
}

UWV_SIMD_CLONES
void narrow(const float* from, std::size_t n, std::uint16_t* to) {
  for (std::size_t i = 0; i < n; ++i) {
    const auto bits = std::bit_cast<std::uint32_t>(from[i]);
    to[i] = static_cast<std::uint16_t>((bits + 0x7fffU + ((bits >> 16) & 1U)) >> 16);
  }
}

UWV_SIMD_CLONES
float mean(const float* x, std::size_t n) {
  float sums[lanes] = {};
  std::size_t i = 0;
  for (; i + lanes <= n; i += lanes)
    for (std::size_t k = 0; k < lanes; ++k) sums[k] += x[i + k];
  for (; i < n; ++i) sums[0] += x[i];
  return sum_of(sums) / static_cast<float>(n);
}

UWV_SIMD_CLONES
float mean_square(const float* x, std::size_t n, float centre) {
  float sums[lanes] = {};
  std::size_t i = 0;
  for (; i + lanes <= n; i += lanes)
    for (std::size_t k = 0; k < lanes; ++k) sums[k] += (x[i + k] - centre) * (x[i + k] - centre);
  for (; i < n; ++i) sums[0] += (x[i] - centre) * (x[i] - centre);
  return sum_of(sums) / static_cast<float>(n);
}

UWV_SIMD_CLONES
float largest(const float* x, std::size_t n) {
  float most[lanes] = {};
  std::size_t i = 0;
  for (; i + lanes <= n; i += lanes)
    for (std::size_t k = 0; k < lanes; ++k) most[k] = std::max(most[k], std::abs(x[i + k]));
  for (; i < n; ++i) most[0] = std::max(most[0], std::abs(x[i]));
  return *std::max_element(most, most + lanes);
}

UWV_SIMD_CLONES
void modulate(const float* x, std::size_t n, float centre, float factor, const float* scale, const float* shift,
              float* to) {
  for (std::size_t i = 0; i < n; ++i) to[i] = (x[i] - centre) * factor * scale[i] + shift[i];
}

UWV_SIMD_CLONES
void scale_by(float* x, std::size_t n, float factor, const float* weight) {
  for (std::size_t i = 0; i < n; ++i) x[i] = x[i] * factor * weight[i];
}

UWV_SIMD_CLONES
void scale_and_add(float* x, std::size_t n, float factor, const float* bias) {
  for (std::size_t i = 0; i < n; ++i) x[i] = x[i] * factor + bias[i];
}

UWV_SIMD_CLONES
void add_product(float* x, const float* y, const float* gate, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) x[i] += y[i] * gate[i];
}

UWV_SIMD_CLONES
void add(float* x, const float* y, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) x[i] += y[i];
}

UWV_SIMD_CLONES
void rotate(float* x, std::size_t pairs, const float* cosine, const float* sine) {
  for (std::size_t j = 0; j < pairs; ++j) {
    const float a = x[2 * j], b = x[2 * j + 1];
    x[2 * j] = a * cosine[j] - b * sine[j];
    x[2 * j + 1] = a * sine[j] + b * cosine[j];
  }
}

UWV_SIMD_CLONES
void round_to_i8(const float* x, std::size_t n, float factor, std::int8_t* to) {
  // Adding and taking away 1.5 * 2^23 rounds to the nearest whole number without a call.
  constexpr float round = 12582912.0F;
  for (std::size_t i = 0; i < n; ++i) to[i] = static_cast<std::int8_t>((x[i] * factor + round) - round);
}

}  // namespace uwv::model::row
