// SPDX-License-Identifier: Apache-2.0
// The prompts as the transformer reads them.
#pragma once

#include <ATen/core/Tensor.h>

#include "model/diffusion/checkpoint_folder.h"
#include "uwv/core/monitor.h"

namespace uwv::model {

struct PromptEmbeddings {
  at::Tensor positive, negative;  ///< (1, tokens, width) float32; negative undefined where it was not asked for.
};

/// By the checkpoint's encoder, run on `device`, or out of options.prompt_embeds. Throws Error.
PromptEmbeddings embed_prompts(const ModelOptions& options, const CheckpointFolder& folder, bool with_negative,
                               c10::Device device, Monitor& monitor);

}  // namespace uwv::model
