// SPDX-License-Identifier: Apache-2.0
// The autoencoder's normalisation, over the channels of each pixel, with the SiLU that follows it, in one pass.
#pragma once

#include <ATen/core/Tensor.h>

#include <string>

#include "model/weights/weight_files.h"

namespace uwv::model {

/// Sheet model.md, 7: x / max(|x|, 1e-12) * sqrt(C) * gamma, |x| the length of a pixel's C channels.
class RmsNorm {
 public:
  /// Reads `name`.gamma.
  RmsNorm(const WeightFiles& weights, const std::string& name);

  /// `frame` and `out` are (H, W, C), contiguous, float32 or bfloat16 both; sums are float32. Throws
  /// Error(value_invalid) naming this layer when a pixel is not finite (or its squares are not: beyond 1e18).
  void operator()(const at::Tensor& frame, at::Tensor& out) const { run(frame, out, false); }
  /// SiLU of the above.
  void with_silu(const at::Tensor& frame, at::Tensor& out) const { run(frame, out, true); }

 private:
  void run(const at::Tensor& frame, at::Tensor& out, bool silu) const;

  std::string name_;
  at::Tensor gamma_;  ///< (C), float32, times sqrt(C).
};

}  // namespace uwv::model
