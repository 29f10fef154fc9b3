// SPDX-License-Identifier: Apache-2.0
// The memory ladder: which form of each part is used, and why.
#pragma once

#include <string>
#include <vector>

#include "model/layers/linear.h"
#include "model/transformer/transformer_config.h"
#include "model/vae/vae_options.h"
#include "uwv/core/image.h"
#include "uwv/model/model_options.h"

namespace uwv::model {

struct Rungs {
  LinearForm form = LinearForm::f32;
  bool streamed = false;
  VaeOptions vae;
  std::vector<std::string> reasons;  ///< One sentence for each choice that was automatic.
};

/// What the options ask for; what they leave open is the most exact that fits.
Rungs choose_rungs(const ModelOptions& options, const TransformerConfig& config);

}  // namespace uwv::model
