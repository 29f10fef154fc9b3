// SPDX-License-Identifier: Apache-2.0
// How long the steps take, of what one pass of the transformer takes.
#pragma once

#include <cstddef>

#include "model/diffusion/denoise.h"

namespace uwv::model {

struct PassSeconds {
  double computing = 0;      ///< Of one prompt over one window.
  double rounding = 0;       ///< Of weights, in each pass, for however many prompts.
  double reading = 0;        ///< Of the weights a pass reads from disk, while it computes; 0 = none.
  double first_reading = 0;  ///< The same of the very first pass, which may find some in memory.
  bool stays = false;        ///< What was read once stays in memory: later passes read nothing.
};

struct DenoiseSeconds {
  double all = 0, a_step = 0;  ///< A step's: the mean, without the first pass's reading where only that reads.
};

/// The next block is read while one is computed, so that a pass takes the longer of both.
DenoiseSeconds denoise_seconds(const DenoiseOptions& denoise, std::size_t windows, const PassSeconds& pass);

}  // namespace uwv::model
