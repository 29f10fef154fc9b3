// SPDX-License-Identifier: Apache-2.0
// Where the parts of a checkpoint lie. docs/model.md shows the layout.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "uwv/model/model_options.h"

namespace uwv::model {

struct CheckpointFolder {
  std::string transformer, vae;
  std::string text_encoder, tokenizer;                ///< Both empty where the checkpoint has none.
  std::string scheduler_config;                       ///< The file, or empty.
  std::vector<std::pair<std::string, double>> loras;  ///< Files with their weights.

  /// Throws Error(file_not_found) naming the part that is missing and how to have it, Error(value_invalid) for a
  /// LoRA's weight out of range.
  static CheckpointFolder find(const ModelOptions& options);
};

}  // namespace uwv::model
