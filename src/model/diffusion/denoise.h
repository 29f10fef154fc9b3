// SPDX-License-Identifier: Apache-2.0
// The walk from noise to a clip's latents: sampler, guidance, windows, step caching in one loop. Sheet model.md, 4.
//
// The network is handed in, so that the loop can be held against anything whose velocity is known.
#pragma once

#include <ATen/core/Tensor.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "model/diffusion/windows.h"
#include "model/sampling/sampler.h"

namespace uwv::model {

/// Which of guidance's two velocities is meant, or both in one pass of batch 2.
enum class Branch { positive, negative, both };

/// The network on one window of the clip. Latents are (1, 16, frames, rows, columns), float32; the answer has the same
/// shape, for `both` batch 2: positive, negative.
class WindowModel {
 public:
  virtual ~WindowModel() = default;
  virtual at::Tensor velocity(const at::Tensor& latents, double timestep, Branch branch) = 0;
};

struct DenoiseOptions {
  SamplerOptions sampler;
  double guidance = 4;     ///< v = negative + guidance * (positive - negative). 1 = positive alone, half the passes.
  double cfg_share = 1;    ///< On this share of the steps, from the first on; positive alone after that.
  bool cfg_batch = false;  ///< Both branches in one pass of batch 2 instead of two passes.

  void check() const;
  /// Whether step `step` of the sampler's needs the negative branch.
  bool guided(int step) const;
};

/// A window and what computes it. Without a model nothing in it is to be generated: it ends at `known`.
struct DenoiseWindow {
  Window place;
  std::unique_ptr<WindowModel> model;
  /// (1, 1, frames, rows, columns), true where latents end at `known` too; undefined = nowhere.
  at::Tensor left_out{};
};

/// After each step: the latents, and the clip they point to, without noise. May throw to stop.
struct DenoiseStep {
  int done = 0, total = 0;
  const at::Tensor& latents;
  const at::Tensor& noiseless;
};

/// Works where `noise` lies, and so must `known`, `left_out` and what the models give. `noise` is (1, 16, latent
/// frames, rows, columns); `known` the latents of the same shape that windows without a model and latents that are left
/// out end at, undefined when there are neither. Throws Error(value_invalid) naming the step that gave no numbers.
at::Tensor denoise(const at::Tensor& noise, const std::vector<DenoiseWindow>& windows, const at::Tensor& known,
                   const DenoiseOptions& options, const std::function<void(const DenoiseStep&)>& on_step = {});

}  // namespace uwv::model
