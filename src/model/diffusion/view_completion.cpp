// SPDX-License-Identifier: Apache-2.0
#include "uwv/model/view_completion.h"

#include "model/diffusion/completion_job.h"
#include "model/layers/torch_scope.h"

namespace uwv {

CompletionSummary complete_views(const ModelOptions& options, const RenderedClip& clip, const CompletedClip& out,
                                 int threads, Monitor& monitor) {
  options.check();
  require(static_cast<bool>(out.write), "complete_views: out.write is empty, wanted a function that takes frames");
  const model::TorchScope scope(threads);
  return model::CompletionJob(options, clip, out, monitor).run();
}

void check_checkpoint(const ModelOptions& options) {
  options.check();
  model::set_up(options, {16, 16}, 1);
}

}  // namespace uwv
