// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/window_network.h"

#include <ATen/ATen.h>

namespace uwv::model {

WindowNetwork::WindowNetwork(const WanTransformer& network, const WindowInputs& inputs, double step_cache,
                             PassCount& count)
    : network_(network), inputs_(inputs), step_cache_(step_cache), count_(count) {}

WindowNetwork::Prepared& WindowNetwork::prepared(Branch branch) {
  const auto found = branches_.find(branch);
  if (found != branches_.end()) return found->second;
  const at::Tensor text = branch == Branch::positive   ? inputs_.positive
                          : branch == Branch::negative ? inputs_.negative
                                                       : at::cat({inputs_.positive, inputs_.negative});
  TransformerContext context = branches_.empty()
                                   ? network_.prepare(inputs_.control, inputs_.reference, text, inputs_.control_scale)
                                   : network_.with_text(branches_.begin()->second.context, text);
  context.kept = inputs_.kept;
  return branches_.emplace(branch, Prepared{std::move(context), StepCache(step_cache_)}).first->second;
}

at::Tensor WindowNetwork::velocity(const at::Tensor& latents, double timestep, Branch branch) {
  Prepared& ready = prepared(branch);
  const std::int64_t batch = branch == Branch::both ? 2 : 1;
  TransformerHooks hooks;
  hooks.between = [&](std::string_view, double done) {
    if (count_.between) count_.between(done);
  };
  if (step_cache_ > 0) hooks.skip_blocks = [&](const at::Tensor& modulated) { return ready.cache.may_skip(modulated); };
  const int skipped = ready.cache.skipped();
  const at::Tensor answer =
      network_.forward(ready.context, latents.expand({batch, -1, -1, -1, -1}), at::full({batch}, timestep), hooks);
  (ready.cache.skipped() > skipped ? count_.skipped : count_.passes) += batch;
  return answer;
}

}  // namespace uwv::model
