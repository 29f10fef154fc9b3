// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/denoise.h"

#include <ATen/ATen.h>

#include <cmath>

#include "uwv/core/error.h"

namespace uwv::model {
namespace {

at::Tensor guided_velocity(WindowModel& model, const at::Tensor& latents, double timestep,
                           const DenoiseOptions& options) {
  at::Tensor positive, negative;
  if (options.cfg_batch) {
    const at::Tensor both = model.velocity(latents, timestep, Branch::both);
    positive = both.narrow(0, 0, 1);
    negative = both.narrow(0, 1, 1);
  } else {
    positive = model.velocity(latents, timestep, Branch::positive);
    negative = model.velocity(latents, timestep, Branch::negative);
  }
  return negative + (positive - negative) * options.guidance;
}

at::Tensor window_velocity(const DenoiseWindow& window, const at::Tensor& latents, const at::Tensor& known,
                           const Sampler& sampler, const DenoiseOptions& options) {
  const auto to_known = [&] { return (latents - known) / sampler.sigma(); };
  if (!window.model) return to_known();
  const at::Tensor velocity = options.guided(sampler.taken())
                                  ? guided_velocity(*window.model, latents, sampler.timestep(), options)
                                  : window.model->velocity(latents, sampler.timestep(), Branch::positive);
  return window.left_out.defined() ? at::where(window.left_out, to_known(), velocity) : velocity;
}

at::Tensor clip_velocity(const std::vector<DenoiseWindow>& windows, const at::Tensor& latents, const at::Tensor& known,
                         const Sampler& sampler, const DenoiseOptions& options) {
  const auto part = [](const at::Tensor& clip, const Window& place) {
    return clip.defined() ? clip.narrow(2, place.first, place.count) : at::Tensor();
  };
  if (windows.size() == 1) return window_velocity(windows.front(), latents, known, sampler, options);
  at::Tensor sum = at::zeros_like(latents);
  for (const DenoiseWindow& window : windows) {
    const at::Tensor velocity =
        window_velocity(window, part(latents, window.place), part(known, window.place), sampler, options);
    const at::Tensor weights = at::tensor(window.place.weights).to(latents.device()).view({1, 1, -1, 1, 1});
    part(sum, window.place).add_(velocity * weights);
  }
  return sum;
}

}  // namespace

void DenoiseOptions::check() const {
  sampler.check();
  require(std::isfinite(guidance) && guidance >= 0 && guidance <= 100, "guidance: found {}, wanted 0 to 100", guidance);
  require(cfg_share >= 0 && cfg_share <= 1, "cfg_share: found {}, wanted 0 to 1", cfg_share);
}

bool DenoiseOptions::guided(int step) const { return guidance > 1 && step < std::lround(cfg_share * sampler.steps); }

at::Tensor denoise(const at::Tensor& noise, const std::vector<DenoiseWindow>& windows, const at::Tensor& known,
                   const DenoiseOptions& options, const std::function<void(const DenoiseStep&)>& on_step) {
  options.check();
  require(!windows.empty(), "a clip is made of {} windows, wanted 1 or more", windows.size());
  Sampler sampler(options.sampler);
  at::Tensor latents = noise;
  while (sampler.taken() < sampler.steps()) {
    const double sigma = sampler.sigma();
    const at::Tensor velocity = clip_velocity(windows, latents, known, sampler, options);
    const at::Tensor clip = on_step ? noiseless(latents, velocity, sigma) : at::Tensor();
    latents = sampler.step(latents, velocity);
    if (on_step) on_step({sampler.taken(), sampler.steps(), latents, clip});
  }
  return latents;
}

}  // namespace uwv::model
