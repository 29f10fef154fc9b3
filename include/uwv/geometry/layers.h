// SPDX-License-Identifier: Apache-2.0
// Foreground and background as two layers (paper, "Layer-wise Point Cloud Construction").
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "uwv/core/mask.h"
#include "uwv/core/monitor.h"
#include "uwv/core/thread_pool.h"
#include "uwv/geometry/scene_geometry.h"

namespace uwv {

/// 1 = belongs to the foreground, which may move; 0 = background.
using ForegroundMask = Mask<struct ForegroundTag>;

/// Finds what a picture is about. Implementations: u2netp (make_saliency_network), TorchScript nets (uwv::model).
class ForegroundFinder {
 public:
  virtual ~ForegroundFinder() = default;
  /// Probability of foreground in [0, 1], sized as the picture.
  virtual Image<float> find(const ImageRgb& picture) = 0;
  virtual std::string name() const = 0;
};

}  // namespace uwv
