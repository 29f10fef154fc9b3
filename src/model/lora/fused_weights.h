// SPDX-License-Identifier: Apache-2.0
// A checkpoint's weights with low-rank changes added as they are read. The files are never changed, so leaving a change
// out gives the original bits again. Sheet model.md, 5.
#pragma once

#include <ATen/core/Tensor.h>

#include <map>
#include <string>
#include <vector>

#include "model/lora/lora_file.h"
#include "model/weights/weight_files.h"

namespace uwv::model {

class FusedWeights {
 public:
  explicit FusedWeights(WeightFiles files) : files_(std::move(files)) {}

  /// Throws Error(value_invalid) naming each tensor the changes are for that the checkpoint lacks or holds in another
  /// shape.
  void set_changes(std::vector<WeightedLora> changes);

  const WeightFiles& files() const { return files_; }
  bool has(const std::string& name) const { return files_.has(name); }
  /// As stored and without a copy where nothing changes it; else float32, the sum worked out in float32.
  at::Tensor tensor(const std::string& name) const;
  /// Whether the weight is stored in 8 bits and nothing changes it: then it is files().quantised().
  bool stays_quantised(const std::string& name) const;

 private:
  bool is_changed(const std::string& name) const;
  WeightFiles files_;
  std::vector<WeightedLora> changes_;
};

}  // namespace uwv::model
