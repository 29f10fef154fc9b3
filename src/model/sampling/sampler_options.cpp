// SPDX-License-Identifier: Apache-2.0
#include "uwv/model/sampler_options.h"

#include <cmath>

#include "uwv/core/error.h"

namespace uwv::model {
namespace {

constexpr double train_steps = 1000;
/// UniPC takes the logarithm of 1 - sigma; the reference keeps the first sigma this far from 1.
constexpr double below_one = 1e-6;

double shifted(double sigma, double shift) { return shift * sigma / (1 + (shift - 1) * sigma); }

double between(double first, double last, int i, int intervals) {
  return intervals == 0 ? first : i == intervals ? last : first + i * ((last - first) / intervals);
}

/// Before the shift, for step i of n.
double unshifted(const SamplerOptions& o, int i) {
  switch (o.kind) {
    case SamplerKind::euler: return between(1, static_cast<float>(shifted(1 / train_steps, o.shift)), i, o.steps - 1);
    case SamplerKind::euler_plain: return between(1, 0, i, o.steps);
    case SamplerKind::unipc: return between(1, 1 / train_steps, i, o.steps);
    default: return 1 - between(1, 1 / train_steps, o.steps - i, o.steps);
  }
}

double sigma_at(const SamplerOptions& o, int i) {
  const double sigma = shifted(unshifted(o, i), o.shift);
  return o.kind == SamplerKind::unipc && i == 0 && std::abs(sigma - 1) < below_one ? sigma - below_one : sigma;
}

bool whole_timesteps(SamplerKind kind) { return kind != SamplerKind::euler && kind != SamplerKind::euler_plain; }

}  // namespace

std::string_view to_string(SamplerKind kind) {
  switch (kind) {
    case SamplerKind::euler: return "euler";
    case SamplerKind::euler_plain: return "euler_plain";
    case SamplerKind::unipc: return "unipc";
    case SamplerKind::unipc_legacy: return "unipc_legacy";
    default: return "dpmpp";
  }
}

void SamplerOptions::check() const {
  require(steps >= 1 && steps <= 1000, "steps: found {}, wanted 1 to 1000", steps);
  require(shift >= 0.01 && shift <= 100, "shift: found {}, wanted 0.01 to 100", shift);
}

SamplerTable sampler_table(const SamplerOptions& options) {
  options.check();
  SamplerTable table;
  for (int i = 0; i < options.steps; ++i) {
    const double sigma = sigma_at(options, i);
    table.sigmas.push_back(static_cast<float>(sigma));
    table.timesteps.push_back(whole_timesteps(options.kind) ? static_cast<float>(std::trunc(train_steps * sigma))
                                                            : static_cast<float>(train_steps) * table.sigmas.back());
  }
  table.sigmas.push_back(0);
  return table;
}

}  // namespace uwv::model
