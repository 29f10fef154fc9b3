// SPDX-License-Identifier: Apache-2.0
// A linear layer whose weight may be held in fewer bits than it is multiplied in.
#pragma once

#include <ATen/core/Tensor.h>

#include <string>

#include "model/weights/weight_files.h"

namespace uwv::model {

/// How a weight is held and multiplied. What a file holds in fewer bits than asked for stays as it is.
enum class LinearForm {
  f32,          ///< Multiplied in float32: the exact answer.
  bf16_stored,  ///< Held in bfloat16, multiplied in float32: half the memory, for CPUs without bfloat16 units.
  bf16,         ///< Held and multiplied in bfloat16, summed in float32: fast where the CPU has units for it.
  int8_stored,  ///< Held in 8-bit whole numbers, one scale an output channel, multiplied in float32: a quarter.
  int8,         ///< Held so, and multiplied with tokens rounded to 8 bits, one scale a token: fastest with VNNI or AMX.
};

/// The form's name as options give it: "f32", "bf16_stored", ...
std::string to_string(LinearForm form);
/// Throws std::invalid_argument listing the names for any other.
LinearForm linear_form(const std::string& name);
/// The type in which tokens are best handed to layers of a form.
at::ScalarType token_type(LinearForm form);

/// Tokens made ready for layers of one form, so that several layers that read the same ones share the work.
struct LinearInput {
  at::Tensor x;         ///< (rows, in)
  at::Tensor scales;    ///< Of int8: one a row; else undefined.
  at::ScalarType type;  ///< Of the answer.
};

class Linear {
 public:
  Linear() = default;
  /// `weight` is (out, in), `bias` (out) or undefined. A weight that needs no rounding is kept, not copied: what it
  /// views must outlive the layer.
  Linear(const at::Tensor& weight, const at::Tensor& bias, LinearForm form);
  /// Reads prefix + ".weight" and, where there is one, prefix + ".bias".
  Linear(const WeightFiles& weights, const std::string& prefix, LinearForm form);

  /// x is (..., in) in float32 or bfloat16; the answer is (..., out) in the type of x.
  at::Tensor operator()(const at::Tensor& x) const;

  /// The same in two steps; the answer is (rows, out).
  LinearInput prepare(const at::Tensor& x) const;
  at::Tensor operator()(const LinearInput& input) const;

  bool defined() const { return weight_.defined(); }

 private:
  at::Tensor widened(std::int64_t begin, std::int64_t end) const;
  at::Tensor multiply_widened(const at::Tensor& x) const;

  at::Tensor weight_, bias_;
  at::Tensor scales_;  ///< Of 8-bit forms: one an output channel.
  std::int64_t out_ = 0;
  LinearForm form_ = LinearForm::f32;
};

}  // namespace uwv::model
