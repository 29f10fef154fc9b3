// SPDX-License-Identifier: Apache-2.0
#include "model/vae/rms_norm_kernel.h"

#include <bit>
#include <cmath>
#include <limits>

#include "uwv/core/simd.h"

namespace uwv::model::kernel {
namespace {

constexpr std::int64_t lanes = 16;

inline float load(float x) { return x; }
inline float load(Bf16 x) { return std::bit_cast<float>(static_cast<std::uint32_t>(x.bits) << 16); }

inline void store(float& to, float x) { to = x; }
inline void store(Bf16& to, float x) {
  // To the nearest, ties to even; x is finite.
  const auto bits = std::bit_cast<std::uint32_t>(x);
  to.bits = static_cast<std::uint16_t>((bits + 0x7fffU + ((bits >> 16) & 1U)) >> 16);
}

/// e^x to 2 units in the last place, in operations that vectorise; x in [-60, 60].
inline float fast_exp(float x) {
  const float n = std::floor(x * 1.44269504F + 0.5F);
  // ln 2 in two parts, so that the remainder keeps its digits.
  const float r = (x - n * 0.693359375F) + n * 2.12194440e-4F;
  float p = 1.9875691500e-4F;
  p = p * r + 1.3981999507e-3F;
  p = p * r + 8.3334519073e-3F;
  p = p * r + 4.1665795894e-2F;
  p = p * r + 1.6666665459e-1F;
  p = p * r + 5.0000001201e-1F;
  p = p * r * r + r + 1.0F;
  return p * std::bit_cast<float>((static_cast<std::int32_t>(n) + 127) << 23);
}

inline float silu(float x) {
  // Beyond 60 the answer is x or within 1e-24 of 0. Bounds nearer to float's range would have the compiler divide by
  // numbers that give denormal quotients, which take a hundred cycles each even where they are then thrown away.
  float bounded = x < -60.0F ? -60.0F : x;
  bounded = bounded > 60.0F ? 60.0F : bounded;
  return x / (1.0F + fast_exp(-bounded));
}

/// In sixteen sums side by side, in the same order whatever the processor.
template <class Number>
inline float sum_of_squares(const Number* x, std::int64_t channels) {
  float sums[lanes] = {};
  std::int64_t c = 0;
  for (; c + lanes <= channels; c += lanes) {
    for (std::int64_t i = 0; i < lanes; ++i) {
      const float value = load(x[c + i]);
      sums[i] += value * value;
    }
  }
  for (std::int64_t i = 0; c + i < channels; ++i) sums[i] += load(x[c + i]) * load(x[c + i]);
  for (std::int64_t half = lanes / 2; half > 0; half /= 2)
    for (std::int64_t i = 0; i < half; ++i) sums[i] += sums[i + half];
  return sums[0];
}

template <bool with_silu, class Number>
inline bool normalise(const NormRun<Number>& run) {
  bool finite = true;
  for (std::int64_t pixel = 0; pixel < run.pixels; ++pixel) {
    const Number* __restrict__ from = run.from + pixel * run.channels;
    Number* __restrict__ to = run.to + pixel * run.channels;
    const float* __restrict__ gamma = run.gamma;
    const float squares = sum_of_squares(from, run.channels);
    finite = finite && squares <= std::numeric_limits<float>::max();
    const float length = std::sqrt(squares);
    const float factor = 1.0F / (length > 1e-12F ? length : 1e-12F);
    for (std::int64_t c = 0; c < run.channels; ++c) {
      const float y = load(from[c]) * factor * gamma[c];
      store(to[c], with_silu ? silu(y) : y);
    }
  }
  return finite;
}

}  // namespace

UWV_SIMD_CLONES bool rms_norm(const NormRun<float>& run) { return normalise<false>(run); }
UWV_SIMD_CLONES bool rms_norm(const NormRun<Bf16>& run) { return normalise<false>(run); }
UWV_SIMD_CLONES bool rms_norm_silu(const NormRun<float>& run) { return normalise<true>(run); }
UWV_SIMD_CLONES bool rms_norm_silu(const NormRun<Bf16>& run) { return normalise<true>(run); }

}  // namespace uwv::model::kernel
