// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/step_cache.h"

#include <ATen/ATen.h>

#include <limits>

namespace uwv::model {

bool StepCache::may_skip(const at::Tensor& modulated) {
  const bool comparable = last_.defined() && last_.sizes() == modulated.sizes();
  const double size = comparable ? last_.abs().mean().item<double>() : 0;
  changed_ +=
      size > 0 ? (modulated - last_).abs().mean().item<double>() / size : std::numeric_limits<double>::infinity();
  last_ = modulated.clone();
  if (changed_ < threshold_) return ++skipped_, true;
  changed_ = 0;
  return false;
}

}  // namespace uwv::model
