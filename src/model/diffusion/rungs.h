// SPDX-License-Identifier: Apache-2.0
// The memory ladder: which form of each part is used, and why.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/diffusion/costs.h"
#include "uwv/model/model_options.h"

namespace uwv::model {

/// What is to be done, as far as memory depends on it.
struct JobSize {
  ClipSize clip;                     ///< Padded.
  PassSize pass;                     ///< Of its largest window.
  std::optional<TinyVaeSizes> fast;  ///< The tiny decoder that makes the frames, where one is asked for.
  bool previews = false;             ///< Of each step; by the tiny decoder, where there is one.

  bool decodes_previews() const { return previews && fast.has_value(); }
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

/// Bytes of main memory that are free, less a tenth for others; 8 GiB where the system does not tell.
double available_memory();

/// Of the clip, by the tiny decoder where one is asked for.
PartCost decoding_cost(const VaeConfig& config, const VaeOptions& options, const JobSize& job);

/// Of the large autoencoder: the larger of encoding and, where no tiny decoder does it, decoding.
double vae_bytes(const VaeConfig& config, const VaeOptions& options, const JobSize& job);

/// Of all that is there while the transformer works, or while a preview is decoded between two steps.
double denoising_bytes(const PartCost& transformer, const JobSize& job, VaePrecision precision);

}  // namespace uwv::model
