// SPDX-License-Identifier: Apache-2.0
#include "model/sampling/sampler.h"

#include <ATen/ATen.h>

#include <algorithm>
#include <cmath>

#include "uwv/core/error.h"

namespace uwv::model {
namespace {

/// The weights that make the corrector of order 2 exact for polynomials (UniPC, B2): of the older difference, of the
/// newest.
struct CorrectorWeights {
  double older, newest;
};

CorrectorWeights corrector_weights(double older_ratio, double hh) {
  const double b = std::expm1(hh);
  const double phi1 = b / hh - 1;
  const double phi2 = phi1 / hh - 0.5;
  const double first = phi1 / b, second = 2 * phi2 / b;
  // [1 1; r 1] w = [first; second]
  const double older = (first - second) / (1 - older_ratio);
  return {older, first - older};
}

}  // namespace

double Sampler::lambda(int step) const {
  // A sigma that rounds to 1 has no logarithm; half of float32's step below 1 stands for the distance.
  constexpr double nearest_to_one = 0x1p-25;
  return std::log(std::max(1 - sigma(step), nearest_to_one)) - std::log(sigma(step));
}

/// Two older steps must be there, apart from each other, and the end point's infinite lambda allows only order 1.
bool Sampler::second_order(int step) const {
  return clips_.size() > 1 && step + 1 < steps() && sigma(step + 1) < sigma(step) && sigma(step) < sigma(step - 1);
}

at::Tensor Sampler::predict(const at::Tensor& latents) const {
  const double from = sigma(taken_), to = sigma(taken_ + 1);
  if (to == 0) return clips_[0];
  const double h = lambda(taken_ + 1) - lambda(taken_);
  const double gain = (1 - to) * std::expm1(-h);
  at::Tensor next = latents * (to / from) - clips_[0] * gain;
  if (last_was_second_order_) {
    const double ratio = (lambda(taken_ - 1) - lambda(taken_)) / h;
    next = next - (clips_[1] - clips_[0]) * (0.5 * gain / ratio);
  }
  return next;
}

/// UniPC's second look at the latents this step begins with, now that the network has seen them.
at::Tensor Sampler::correct(const at::Tensor& clip) const {
  const double from = sigma(taken_ - 1), to = sigma(taken_);
  const double h = lambda(taken_) - lambda(taken_ - 1);
  const double gain = (1 - to) * std::expm1(-h);
  at::Tensor corrected = before_ * (to / from) - clips_[0] * gain;
  if (!last_was_second_order_) return corrected - (clip - clips_[0]) * (0.5 * gain);
  const double ratio = (lambda(taken_ - 2) - lambda(taken_ - 1)) / h;
  const CorrectorWeights weights = corrector_weights(ratio, -h);
  return corrected - (clips_[1] - clips_[0]) * (gain * weights.older / ratio) -
         (clip - clips_[0]) * (gain * weights.newest);
}

at::Tensor Sampler::step(const at::Tensor& latents, const at::Tensor& velocity) {
  require(taken_ < steps(), "step {} of a sampler with {} steps", taken_ + 1, steps());
  at::Tensor next;
  if (options_.kind == SamplerKind::euler || options_.kind == SamplerKind::euler_plain) {
    next = latents + velocity * (sigma(taken_ + 1) - sigma(taken_));
  } else {
    const at::Tensor clip = noiseless(latents, velocity, sigma());
    const bool corrects = options_.kind != SamplerKind::dpmpp && taken_ > 0 && sigma(taken_) < sigma(taken_ - 1);
    before_ = corrects ? correct(clip) : latents;
    clips_.push_front(clip);
    if (clips_.size() > 2) clips_.pop_back();
    last_was_second_order_ = second_order(taken_);
    next = predict(before_);
  }
  if (!at::isfinite(next).all().item<bool>())
    fail(ErrorCode::value_invalid,
         "sampler: step {} of {} gave values that are no numbers; compute in f32, or lower guidance or LoRA weights",
         taken_ + 1, steps());
  ++taken_;
  return next;
}

}  // namespace uwv::model
