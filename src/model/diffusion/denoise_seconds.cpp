// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/denoise_seconds.h"

#include <algorithm>

namespace uwv::model {

DenoiseSeconds denoise_seconds(const DenoiseOptions& denoise, std::size_t windows, const PassSeconds& pass) {
  const double later = pass.stays ? 0 : pass.reading;
  const auto prompts_at_once = [&](int step) { return denoise.guided(step) && denoise.cfg_batch ? 2 : 1; };
  double all = 0;
  for (int step = 0; step < denoise.sampler.steps; ++step) {
    const int at_once = prompts_at_once(step), passes = (denoise.guided(step) ? 2 : 1) / at_once;
    all += passes * std::max(at_once * pass.computing + pass.rounding, later);
  }
  all *= static_cast<double>(windows);
  const double first = prompts_at_once(0) * pass.computing + pass.rounding;
  const double waiting = std::max(first, pass.first_reading) - std::max(first, later);
  return {all + waiting, all / denoise.sampler.steps};
}

}  // namespace uwv::model
