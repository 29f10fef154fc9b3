// SPDX-License-Identifier: Apache-2.0
// The loops of RmsNorm, in a file of their own because they are compiled once per kind of processor.
#pragma once

#include <cstdint>

namespace uwv::model::kernel {

/// bfloat16 as it is stored: the upper half of a float.
struct Bf16 {
  std::uint16_t bits;
};

template <class Number>
struct NormRun {
  const Number* from;
  Number* to;
  const float* gamma;  ///< One per channel.
  std::int64_t pixels, channels;
};

/// False when a pixel's sum of squares was not finite.
bool rms_norm(const NormRun<float>& run);
bool rms_norm(const NormRun<Bf16>& run);
bool rms_norm_silu(const NormRun<float>& run);
bool rms_norm_silu(const NormRun<Bf16>& run);

}  // namespace uwv::model::kernel
