// SPDX-License-Identifier: Apache-2.0
// Names and shapes of all weights of an AutoencoderKLWan. Sheet model.md, 7.
#pragma once

#include "model/vae/vae_config.h"
#include "model/weights/weight_files.h"

namespace uwv::model {

TensorShapes vae_shapes(const VaeConfig& config);

}  // namespace uwv::model
