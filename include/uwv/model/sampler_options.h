// SPDX-License-Identifier: Apache-2.0
// By which steps noise becomes a clip. Sheet model.md, 4 (Scheduler, UniPC).
//
// A flow model names, for latents x = (1 - sigma) * clip + sigma * noise, the velocity noise - clip. A sampler walks
// sigma from about 1 to 0; each step costs one pass of the network (two with guidance), so that the number of steps is
// the first thing to trade. docs/performance.md has the measured error of each sampler and step count.
#pragma once

#include <string_view>
#include <vector>

namespace uwv::model {

enum class SamplerKind {
  euler,         ///< FlowMatchEuler with the official code's table, in which the smallest sigma is shifted twice.
  euler_plain,   ///< The same steps, evenly spaced before one shift.
  unipc,         ///< UniPC of order 2 (bh2), Wan's own, with today's table of diffusers (0.42).
  unipc_legacy,  ///< The same with the table of diffusers 0.35, which the official code pins.
  dpmpp,         ///< DPM-Solver++ of order 2, multistep: UniPC without its corrector.
};

struct SamplerOptions {
  SamplerKind kind = SamplerKind::euler;
  int steps = 8;     ///< Passes of the network, 1..1000. 8 in the official scripts, with a distilled LoRA; 50 without.
  double shift = 5;  ///< Moves steps to where there is more noise: sigma -> s * sigma / (1 + (s - 1) * sigma). Wan asks
                     ///< for 3 at 480 lines and 5 at 720; the official code takes 5. In [0.01, 100].

  /// Few steps for weights that were distilled for it (CausVid LoRA): evenly spaced, with a large shift, because the
  /// first steps decide the layout. Meant for guidance 1.
  static SamplerOptions few_steps(int steps = 4) { return {SamplerKind::euler_plain, steps, 8}; }

  /// Throws std::invalid_argument.
  void check() const;
};

/// Where each step stands.
struct SamplerTable {
  std::vector<float> sigmas;     ///< steps + 1, falling, the last one 0.
  std::vector<float> timesteps;  ///< steps; what the network is told: 1000 * sigma, whole numbers for UniPC and DPM++.
};

/// Throws std::invalid_argument when options.check() does.
SamplerTable sampler_table(const SamplerOptions& options);

/// The name used in options and records, e.g. "unipc_legacy".
std::string_view to_string(SamplerKind kind);

}  // namespace uwv::model
