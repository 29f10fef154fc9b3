// SPDX-License-Identifier: Apache-2.0
// How long a stretch of work with torch's tensors lasts: without gradients, on a number of threads.
#pragma once

#include <ATen/core/grad_mode.h>
#include <c10/core/InferenceMode.h>

namespace uwv::model {

/// torch's number of threads is the process's; it is put back at the end.
class TorchScope {
 public:
  /// `threads` 0 = one per processor.
  explicit TorchScope(int threads);
  ~TorchScope();
  TorchScope(const TorchScope&) = delete;
  TorchScope& operator=(const TorchScope&) = delete;

 private:
  c10::InferenceMode inference_;
  int threads_before_;
};

}  // namespace uwv::model
