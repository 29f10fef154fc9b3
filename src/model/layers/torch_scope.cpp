// SPDX-License-Identifier: Apache-2.0
#include "model/layers/torch_scope.h"

#include <ATen/Parallel.h>

#include <algorithm>
#include <thread>

namespace uwv::model {

TorchScope::TorchScope(int threads) : threads_before_(at::get_num_threads()) {
  at::set_num_threads(threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
}

TorchScope::~TorchScope() { at::set_num_threads(threads_before_); }

}  // namespace uwv::model
