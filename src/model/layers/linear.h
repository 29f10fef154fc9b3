// SPDX-License-Identifier: Apache-2.0
// A linear layer whose weight may be held in fewer bits than it is multiplied in.
#pragma once

#include <ATen/core/Tensor.h>

#include <string>

#include "model/weights/weight_files.h"

namespace uwv::model {

/// How a weight is held and multiplied.
enum class LinearForm {
  f32,          ///< Held and multiplied in float32: the exact answer.
  bf16_stored,  ///< Held in bfloat16, multiplied in float32: half the memory, for CPUs without bfloat16 units.
  bf16,         ///< Held and multiplied in bfloat16, summed in float32: fast where the CPU has units for it.
};

class Linear {
 public:
  Linear() = default;
  /// `weight` is (out, in), `bias` (out) or undefined.
  Linear(const at::Tensor& weight, const at::Tensor& bias, LinearForm form);
  /// Reads prefix + ".weight" and, where there is one, prefix + ".bias".
  Linear(const WeightFiles& weights, const std::string& prefix, LinearForm form);

  /// x is (..., in) in float32 or bfloat16; the answer is (..., out) in the type of x.
  at::Tensor operator()(const at::Tensor& x) const;

 private:
  at::Tensor weight_, bias_;
  LinearForm form_ = LinearForm::f32;
};

}  // namespace uwv::model
