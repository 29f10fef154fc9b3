// SPDX-License-Identifier: Apache-2.0
#include <ATen/ATen.h>

#include <algorithm>
#include <chrono>

#include "uwv/core/processor.h"
#include "uwv/model/compute_devices.h"

namespace uwv {
namespace {

/// A product the size of a layer's, by turns in both numbers, and the best of each, so that what else the machine does
/// weighs on neither.
bool bf16_beats_f32() {
  constexpr std::int64_t tokens = 256, width = 1024;
  constexpr int rounds = 5;
  const auto seconds = [](const at::Tensor& x, const at::Tensor& weight) {
    const auto start = std::chrono::steady_clock::now();
    at::linear(x, weight);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  const at::Tensor x = at::ones({tokens, width}), weight = at::full({width, width}, 0.01);
  const at::Tensor few_bits = x.to(at::kBFloat16), weight_in_few_bits = weight.to(at::kBFloat16);
  double f32 = 1e9, bf16 = 1e9;
  for (int round = 0; round < rounds; ++round) {  // the first sets the library up
    f32 = std::min(f32, seconds(x, weight));
    bf16 = std::min(bf16, seconds(few_bits, weight_in_few_bits));
  }
  return bf16 < f32;
}

}  // namespace

FastNumbers fast_numbers() {
  const ProcessorUnits units = processor_units();
  FastNumbers fast{units.amx_bf16, units.int8()};
  if (fast.bf16 || !units.avx512_bf16) return fast;
  static const bool in_vectors = bf16_beats_f32();
  fast.bf16 = in_vectors;
  return fast;
}

}  // namespace uwv
