// SPDX-License-Identifier: Apache-2.0
// The steps of a sampler on latents. Sheet model.md, 4; W. Zhao et al., "UniPC", 2023; C. Lu et al., "DPM-Solver++",
// 2022.
#pragma once

#include <ATen/TensorOperators.h>
#include <ATen/core/Tensor.h>

#include <deque>

#include "uwv/model/sampler_options.h"

namespace uwv::model {

/// One walk from noise to a clip. Latents are float32 of any shape, the same at every step.
class Sampler {
 public:
  /// Throws std::invalid_argument when options.check() does.
  explicit Sampler(const SamplerOptions& options) : options_(options), table_(sampler_table(options)) {}

  const SamplerTable& table() const { return table_; }
  int steps() const { return options_.steps; }
  /// Steps taken so far.
  int taken() const { return taken_; }
  double sigma() const { return sigma(taken_); }
  double timestep() const { return table_.timesteps.at(static_cast<std::size_t>(taken_)); }

  /// The latents after the next step, given the network's velocity for `latents` at timestep(). Throws
  /// Error(value_invalid) naming the step when the result is not finite.
  at::Tensor step(const at::Tensor& latents, const at::Tensor& velocity);

 private:
  double sigma(int step) const { return table_.sigmas.at(static_cast<std::size_t>(step)); }
  double lambda(int step) const;
  at::Tensor predict(const at::Tensor& latents) const;
  at::Tensor correct(const at::Tensor& clip) const;
  bool second_order(int step) const;

  SamplerOptions options_;
  SamplerTable table_;
  int taken_ = 0;
  std::deque<at::Tensor> clips_;  ///< What the last two steps took for the clip without noise, the newest first.
  at::Tensor before_;             ///< Latents that the last step began with.
  bool last_was_second_order_ = false;
};

/// The clip without noise that a velocity points to.
inline at::Tensor noiseless(const at::Tensor& latents, const at::Tensor& velocity, double sigma) {
  return latents - velocity * sigma;
}

}  // namespace uwv::model
