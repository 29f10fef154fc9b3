// SPDX-License-Identifier: Apache-2.0
// Convolutions of 3x3 in float32 by Winograd's F(4x4, 3x3): a quarter of the products. Frames that are added up (the
// three a causal convolution sees) are added before the way back, so that they cost one matrix product a point of the
// tile. Weights are transformed anew at each call: kept, they would be four times as large as the plain ones, and
// making them took 1 to 4 % of a decode in one piece (each band makes them again).
//
// Rounding is that of float32 on numbers larger than the result: errors of a convolution are four times those of the
// plain sum, at most some 1e-5 of the spread around.
#pragma once

#include <ATen/core/Tensor.h>

#include <vector>

#include "model/vae/frame_pool.h"

namespace uwv::model::winograd {

/// A frame and what it is convolved with.
struct Term {
  at::Tensor frame;   ///< (h, w, C), contiguous, float32 on the CPU.
  at::Tensor weight;  ///< (O, C, 3, 3) as laid_out() gives it.
};

/// The same weight (O, C, 3, 3) with outputs next to each other in memory.
at::Tensor laid_out(const at::Tensor& weight);

/// Whether it works with such weights, and whether it pays for a result of `pixels` pixels.
bool takes(const at::Tensor& weight);
bool pays(std::int64_t pixels);

/// sum (h, w, O), contiguous, becomes the terms' sum plus `bias` (O; may be undefined); with `add` that is added to it.
/// With `doubled` frames are half as high and wide, each pixel standing for 2x2. Frames may have rows that the sum has
/// not: `above` of them (after doubling), and any number below; beyond them are zeros. All terms share C and O. What it
/// needs meanwhile is of `pool`, float32.
void convolve(const FramePool& pool, at::Tensor& sum, const std::vector<Term>& terms, const at::Tensor& bias, bool add,
              bool doubled = false, std::int64_t above = 0);

}  // namespace uwv::model::winograd
