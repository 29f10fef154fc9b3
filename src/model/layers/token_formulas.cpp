// SPDX-License-Identifier: Apache-2.0
#include "model/layers/token_formulas.h"

#include <ATen/ATen.h>

namespace uwv::model::formula {
namespace {

/// (batch or 1, dim) or (dim) as what can be multiplied with (batch, tokens, dim).
at::Tensor per_batch(const at::Tensor& values) { return values.dim() < 2 ? values : values.unsqueeze(-2); }

/// Each pair of neighbouring channels of each head, turned by its token's angle.
at::Tensor turned(const at::Tensor& x, const at::Tensor& cosine, const at::Tensor& sine) {
  const at::Tensor pairs = x.unflatten(-1, {-1, cosine.size(-1), 2});
  const at::Tensor c = cosine.unsqueeze(-2), s = sine.unsqueeze(-2);
  const at::Tensor first = pairs.select(-1, 0), second = pairs.select(-1, 1);
  return at::stack({first * c - second * s, first * s + second * c}, -1).view(x.sizes());
}

}  // namespace

at::Tensor layer_norm(const at::Tensor& x, const at::Tensor& scale, const at::Tensor& shift, double eps,
                      at::ScalarType type) {
  const at::Tensor wide = x.to(at::kFloat);
  const at::Tensor centred = wide - wide.mean(-1, /*keepdim=*/true);
  const at::Tensor factor = at::rsqrt(centred.square().mean(-1, /*keepdim=*/true) + eps);
  return (centred * factor * per_batch(scale) + per_batch(shift)).to(type);
}

void add_gated(const at::Tensor& x, const at::Tensor& y, const at::Tensor& gate) {
  x.add_(gate.defined() ? y.to(at::kFloat) * per_batch(gate) : y.to(at::kFloat));
}

void rms_norm_rotate(const at::Tensor& x, const at::Tensor& weight, double eps, const at::Tensor& cosine,
                     const at::Tensor& sine) {
  const at::Tensor wide = x.to(at::kFloat);
  const at::Tensor normed = wide * at::rsqrt(wide.square().mean(-1, /*keepdim=*/true) + eps) * weight;
  x.copy_(cosine.defined() ? turned(normed, cosine, sine) : normed);
}

std::pair<at::Tensor, at::Tensor> quantise_rows(const at::Tensor& x) {
  const at::Tensor wide = x.to(at::kFloat);
  const at::Tensor largest = wide.abs().amax(-1, /*keepdim=*/true);
  const at::Tensor factor = at::where(largest > 0, 127.0F / largest, at::zeros_like(largest));
  return {at::round(wide * factor).clamp_(-127, 127).to(at::kChar), largest.div(127.0F).flatten()};
}

void scale_rows(const at::Tensor& y, const at::Tensor& scales, const at::Tensor& bias) {
  const at::Tensor scaled = y.to(at::kFloat) * scales.unsqueeze(-1);
  y.copy_(bias.defined() ? scaled + bias : scaled);
}

bool all_finite(const at::Tensor& x) {
  return at::isfinite(x.mean(-1, /*keepdim=*/false, at::kFloat)).all().item<bool>();
}

}  // namespace uwv::model::formula
