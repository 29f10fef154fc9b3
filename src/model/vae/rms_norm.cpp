// SPDX-License-Identifier: Apache-2.0
#include "model/vae/rms_norm.h"

#include <ATen/ATen.h>
#include <ATen/Parallel.h>

#include <atomic>
#include <cmath>

#include "model/vae/rms_norm_kernel.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

/// Pixels one thread takes at a time: enough work to be worth the hand-over.
constexpr std::int64_t grain = 512;

template <class Number>
bool run_rows(const at::Tensor& frame, const at::Tensor& gamma, at::Tensor& out, bool silu) {
  const auto* from = reinterpret_cast<const Number*>(frame.const_data_ptr());
  auto* to = reinterpret_cast<Number*>(out.mutable_data_ptr());
  const std::int64_t channels = gamma.numel();
  std::atomic<bool> finite{true};
  at::parallel_for(0, frame.numel() / channels, grain, [&](std::int64_t begin, std::int64_t end) {
    const kernel::NormRun<Number> run{from + begin * channels, to + begin * channels, gamma.const_data_ptr<float>(),
                                      end - begin, channels};
    if (!(silu ? kernel::rms_norm_silu(run) : kernel::rms_norm(run))) finite = false;
  });
  return finite;
}

/// The same in torch's own operators, for frames that lie elsewhere than on the CPU.
bool run_formula(const at::Tensor& frame, const at::Tensor& gamma, at::Tensor& out, bool silu) {
  constexpr double least_length = 1e-12;
  const at::Tensor wide = frame.to(at::kFloat);
  const at::Tensor squares = wide.square().sum(-1, /*keepdim=*/true);
  const at::Tensor normed = wide / squares.sqrt().clamp_min(least_length) * gamma;
  out.copy_(silu ? at::silu(normed) : normed);
  return at::isfinite(squares).all().item<bool>();
}

}  // namespace

RmsNorm::RmsNorm(const WeightFiles& weights, const std::string& name)
    : name_(weights.path() + ": " + name), gamma_(weights.load(name + ".gamma", at::kFloat).flatten()) {
  gamma_.mul_(std::sqrt(static_cast<double>(gamma_.numel())));
}

void RmsNorm::run(const at::Tensor& frame, at::Tensor& out, bool silu) const {
  require(frame.is_contiguous() && out.is_contiguous() && frame.sizes() == out.sizes() &&
              frame.scalar_type() == out.scalar_type() && frame.size(-1) == gamma_.numel(),
          "RmsNorm {}: {} channels are wanted in two contiguous frames, found {} and {}", name_, gamma_.numel(),
          frame.size(-1), out.size(-1));
  const bool finite = !frame.is_cpu()                     ? run_formula(frame, gamma_, out, silu)
                      : frame.scalar_type() == at::kFloat ? run_rows<float>(frame, gamma_, out, silu)
                                                          : run_rows<kernel::Bf16>(frame, gamma_, out, silu);
  if (!finite)
    fail(ErrorCode::value_invalid,
         "{}: what reaches this layer is not finite (NaN, or beyond what float32 can square); the input holds such "
         "values or the weights are damaged",
         name_);
}

}  // namespace uwv::model
