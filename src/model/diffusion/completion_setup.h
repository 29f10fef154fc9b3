// SPDX-License-Identifier: Apache-2.0
// What follows from the options and a checkpoint's settings alone, before any weight is read.
#pragma once

#include <c10/core/Device.h>

#include "model/diffusion/checkpoint_folder.h"
#include "model/diffusion/denoise.h"
#include "model/diffusion/rungs.h"
#include "uwv/core/image.h"

namespace uwv::model {

struct CompletionSetup {
  c10::Device device = c10::kCPU;  ///< Where all parts of the model are run.
  CheckpointFolder folder;
  TransformerConfig config;
  VaeConfig vae;
  DenoiseOptions denoise;
  std::vector<Window> windows;
  JobSize job;
  Rungs rungs;
  std::vector<std::string> choices;  ///< What was automatic and became what, and why.
};

/// `size` and `frames` are the clip's own. Throws Error: see check_checkpoint, plan_completion.
CompletionSetup set_up(const ModelOptions& options, Size size, long frames);

/// Sides and lengths that fit the network; see RenderedClip.
std::int64_t whole_side(std::int64_t side);

}  // namespace uwv::model
