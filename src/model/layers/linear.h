// SPDX-License-Identifier: Apache-2.0
// A linear layer whose weight may be held in fewer bits than it is multiplied in.
#pragma once

#include <ATen/core/Tensor.h>

#include <string>

#include "model/layers/linear_form.h"
#include "model/weights/weight_files.h"

namespace uwv::model {

/// The type in which tokens are best handed to layers of a form: see token_bytes().
at::ScalarType token_type(LinearForm form);

/// Tokens made ready for layers of one form, so that several layers that read the same ones share the work.
struct LinearInput {
  at::Tensor x;         ///< (rows, in)
  at::Tensor scales;    ///< Of int8: one a row; else undefined.
  at::ScalarType type;  ///< Of the answer.
};

/// Rounds a piece at a time, so that a weight of any type is never held in float32 as a whole.
QuantisedWeight quantised(const at::Tensor& weight);

class Linear {
 public:
  Linear() = default;
  /// `weight` is (out, in), `bias` (out) or undefined. A weight that needs no rounding is kept, not copied: what it
  /// views must outlive the layer.
  Linear(const at::Tensor& weight, const at::Tensor& bias, LinearForm form);
  /// The same of a weight that is 8-bit already. It stays so in every form but bf16, whose multiplication wants nothing
  /// else.
  Linear(const QuantisedWeight& weight, const at::Tensor& bias, LinearForm form);
  /// Reads prefix + ".weight" and, where there is one, prefix + ".bias".
  Linear(const WeightFiles& weights, const std::string& prefix, LinearForm form);

  /// x is (..., in) in float32 or bfloat16; the answer is (..., out) in the type of x.
  at::Tensor operator()(const at::Tensor& x) const;

  /// The same in two steps; the answer is (rows, out).
  LinearInput prepare(const at::Tensor& x) const;
  at::Tensor operator()(const LinearInput& input) const;

  bool defined() const { return weight_.defined(); }

 private:
  void hold(const QuantisedWeight& weight);
  void set_bias(const at::Tensor& bias);
  at::Tensor widened(std::int64_t begin, std::int64_t end) const;
  at::Tensor multiply_widened(const at::Tensor& x, const at::Tensor& bias) const;

  at::Tensor weight_, bias_;
  at::Tensor scales_;    ///< Of 8-bit forms: one an output channel.
  bool packed_ = false;  ///< The weight lies as int8_product wants it.
  std::int64_t out_ = 0;
  LinearForm form_ = LinearForm::f32;
};

}  // namespace uwv::model
