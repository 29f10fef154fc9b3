// SPDX-License-Identifier: Apache-2.0
// The one place that knows torch: a TorchScript file as a function from tensors of floats to tensors of floats.
//
// Nothing of torch's own types shows here, so that one source file alone pays for compiling its headers.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "model/float_tensor.h"

namespace uwv::model {

/// What forward returned: a tensor, a tuple, a list, or a dictionary. None of a tuple is an empty tensor.
struct ModuleOutputs {
  std::vector<FloatTensor> tensors;
  std::vector<std::string> names;  ///< The keys of a dictionary, as many as tensors; else empty.
};

enum class TensorType { float32, bfloat16, float16 };

class ScriptModule {
 public:
  /// Loads onto the CPU. Throws Error: file_not_found, format_unknown (a state dict, safetensors, ONNX... instead of
  /// TorchScript, named), file_damaged, value_invalid (forward does not take `inputs` tensors).
  explicit ScriptModule(const std::string& path, int inputs = 1);
  ~ScriptModule();
  ScriptModule(ScriptModule&&) noexcept;

  const std::string& path() const { return path_; }

  /// Calls forward with as many tensors as it takes, without gradients on `threads` threads (torch's number is the
  /// process's; it is put back after). Throws Error(value_invalid) when the network fails or returns something else
  /// than tensors of numbers.
  ModuleOutputs forward(std::span<const FloatTensor> inputs, TensorType type, int threads);
  ModuleOutputs forward(const FloatTensor& input, TensorType type, int threads) {
    return forward(std::span(&input, 1), type, threads);
  }

 private:
  struct State;
  std::string path_;
  std::unique_ptr<State> state_;
};

}  // namespace uwv::model
