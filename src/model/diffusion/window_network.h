// SPDX-License-Identifier: Apache-2.0
// The transformer on one window of a clip, with all that stays the same from step to step.
#pragma once

#include <functional>
#include <map>
#include <optional>

#include "model/diffusion/denoise.h"
#include "model/diffusion/step_cache.h"
#include "model/transformer/wan_transformer.h"

namespace uwv::model {

/// Passes of the transformer over all windows, and who hears of them.
struct PassCount {
  long passes = 0, skipped = 0;
  /// Before each block: how much of the current pass is done, 0 to 1. May throw to stop.
  std::function<void(double done)> between;
};

/// What a window shows the transformer.
struct WindowInputs {
  at::Tensor control, reference;  ///< Either may be undefined.
  at::Tensor positive, negative;  ///< Texts (1, tokens, width); negative undefined without guidance.
  at::Tensor control_scale;       ///< One factor a VACE block; undefined for ones.
  at::Tensor kept{};              ///< Tokens that take part, see TransformerContext; undefined for all.
};

class WindowNetwork : public WindowModel {
 public:
  /// `network` and `count` must outlive this.
  WindowNetwork(const WanTransformer& network, const WindowInputs& inputs, double step_cache, PassCount& count);

  at::Tensor velocity(const at::Tensor& latents, double timestep, Branch branch) override;

 private:
  struct Prepared {
    TransformerContext context;
    StepCache cache;
  };
  Prepared& prepared(Branch branch);

  const WanTransformer& network_;
  WindowInputs inputs_;
  double step_cache_;
  PassCount& count_;
  std::map<Branch, Prepared> branches_;
};

}  // namespace uwv::model
