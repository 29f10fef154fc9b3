// SPDX-License-Identifier: Apache-2.0
// The memory ladder: which form of each part is used, and why.
#pragma once

#include <string>
#include <vector>

#include "model/diffusion/costs.h"
#include "uwv/model/model_options.h"

namespace uwv::model {

/// What is to be done, as far as memory depends on it.
struct JobSize {
  ClipSize clip;  ///< Padded.
  PassSize pass;  ///< Of its largest window.
};

struct Rungs {
  LinearForm form = LinearForm::f32;
  bool streamed = false;
  VaeOptions vae;
  std::vector<std::string> reasons;  ///< One sentence for each choice that was automatic.
  double limit = 0;                  ///< Bytes that were to be kept.
};

/// What the options ask for; what they leave open is the most exact that is expected to fit `memory_limit`, or what is
/// free where it runs. Off the CPU no form that only the CPU is fast in is chosen. Throws Error(out_of_memory) when
/// nothing does and a limit was given; without one the smallest is taken.
Rungs choose_rungs(const ModelOptions& options, c10::Device device, const TransformerConfig& config,
                   const VaeConfig& vae, const JobSize& job);

/// The larger of encoding and decoding.
double vae_bytes(const VaeConfig& config, const VaeOptions& options, const JobSize& job);

}  // namespace uwv::model
