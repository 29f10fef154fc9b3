// SPDX-License-Identifier: Apache-2.0
// Leaves out passes whose result would hardly differ from the last one's (F. Liu et al., "Timestep Embedding Tells:
// It's Time to Cache for Video Diffusion Model", 2024).
//
// What the first block is given, after modulation by the timestep, tells how much a step changes. Its relative changes
// are summed from step to step; while the sum stays below a threshold, the change that all blocks together made in
// their last run is used again.
#pragma once

#include <ATen/core/Tensor.h>

namespace uwv::model {

/// Of one branch of guidance on one window.
class StepCache {
 public:
  /// `threshold` 0 = never leaves out. Summed relative mean change; docs/performance.md has what each costs.
  explicit StepCache(double threshold) : threshold_(threshold) {}

  /// Whether the step with this input may be left out.
  bool may_skip(const at::Tensor& modulated);
  int skipped() const { return skipped_; }

 private:
  double threshold_;
  double changed_ = 0;
  int skipped_ = 0;
  at::Tensor last_;
};

}  // namespace uwv::model
