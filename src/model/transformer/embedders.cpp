// SPDX-License-Identifier: Apache-2.0
#include "model/transformer/embedders.h"

#include <ATen/ATen.h>

#include <cmath>

#include "model/transformer/weight_access.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

constexpr double longest_period = 10000;

}  // namespace

PatchEmbedder::PatchEmbedder(const FusedWeights& weights, const std::string& prefix) : name_(prefix) {
  const at::Tensor weight = weights.tensor(prefix + ".weight");
  channels_ = weight.size(1);
  patch_ = {weight.size(2), weight.size(3), weight.size(4)};
  linear_ = Linear(weight.flatten(1), weights.tensor(prefix + ".bias"), LinearForm::f32);
}

TokenGrid PatchEmbedder::grid(const at::Tensor& latents) const {
  require(latents.dim() == 5 && latents.size(1) == channels_,
          "{} is given latents of {} dimensions and {} channels, wanted (batch, {}, frames, rows, columns)", name_,
          latents.dim(), latents.dim() > 1 ? latents.size(1) : 0, channels_);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t size = latents.size(static_cast<std::int64_t>(axis) + 2);
    require(size >= patch_[axis] && size % patch_[axis] == 0,
            "{} is given latents of size {} along axis {}, wanted a multiple of {}", name_, size, axis + 2,
            patch_[axis]);
  }
  return {latents.size(2) / patch_[0], latents.size(3) / patch_[1], latents.size(4) / patch_[2]};
}

at::Tensor PatchEmbedder::operator()(const at::Tensor& latents) const {
  const TokenGrid g = grid(latents);
  const std::int64_t batch = latents.size(0);
  const at::Tensor patches =
      latents.to(at::kFloat)
          .reshape({batch, channels_, g.frames, patch_[0], g.rows, patch_[1], g.columns, patch_[2]})
          .permute({0, 2, 4, 6, 1, 3, 5, 7})
          .reshape({batch, g.tokens(), channels_ * patch_[0] * patch_[1] * patch_[2]});
  return linear_(patches);
}

TimeEmbedder::TimeEmbedder(const FusedWeights& weights, int freq_dim)
    : freq_dim_(freq_dim),
      first_(linear(weights, "condition_embedder.time_embedder.linear_1", LinearForm::f32)),
      second_(linear(weights, "condition_embedder.time_embedder.linear_2", LinearForm::f32)),
      parts_(linear(weights, "condition_embedder.time_proj", LinearForm::f32)) {}

TimeEmbedding TimeEmbedder::operator()(const at::Tensor& timestep) const {
  const int half = freq_dim_ / 2;
  // In float32 throughout, as the networks were trained: at timestep 1000 a more exact angle would be another one.
  const at::Tensor frequencies =
      at::exp(at::arange(half, timestep.options().dtype(at::kFloat)).mul(-std::log(longest_period)).div(half));
  const at::Tensor angles = timestep.to(at::kFloat).unsqueeze(1) * frequencies.unsqueeze(0);
  TimeEmbedding time;
  time.sinusoid = at::cat({at::cos(angles), at::sin(angles)}, 1);
  time.embedded = second_(at::silu(first_(time.sinusoid)));
  time.parts = parts_(at::silu(time.embedded)).unflatten(1, {6, -1});
  return time;
}

TextEmbedder::TextEmbedder(const FusedWeights& weights)
    : first_(linear(weights, "condition_embedder.text_embedder.linear_1", LinearForm::f32)),
      second_(linear(weights, "condition_embedder.text_embedder.linear_2", LinearForm::f32)) {}

at::Tensor TextEmbedder::operator()(const at::Tensor& text) const {
  return second_(at::gelu(first_(text.to(at::kFloat)), "tanh"));
}

}  // namespace uwv::model
