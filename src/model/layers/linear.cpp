// SPDX-License-Identifier: Apache-2.0
#include "model/layers/linear.h"

#include <ATen/ATen.h>

#include "model/layers/int8_product.h"
#include "model/layers/token_kernels.h"

namespace uwv::model {
namespace {

/// A weight in few bits is widened so many bytes at a time, which stay in the cache until they are multiplied.
constexpr std::int64_t widened_bytes = 8 << 20;

bool is_int8(LinearForm form) { return form == LinearForm::int8 || form == LinearForm::int8_stored; }

std::int64_t rows_at_once(const at::Tensor& weight) {
  return std::max<std::int64_t>(64, widened_bytes / 4 / weight.size(1));
}

}  // namespace

QuantisedWeight quantised(const at::Tensor& weight) {
  const std::int64_t rows = weight.size(0), step = rows_at_once(weight);
  QuantisedWeight whole{at::empty(weight.sizes(), weight.options().dtype(at::kChar)),
                        at::empty({rows}, weight.options().dtype(at::kFloat))};
  for (std::int64_t begin = 0; begin < rows; begin += step) {
    const std::int64_t end = std::min(begin + step, rows);
    const auto [numbers, scales] = quantise_rows(weight.slice(0, begin, end).to(at::kFloat).contiguous());
    whole.numbers.slice(0, begin, end).copy_(numbers);
    whole.scales.slice(0, begin, end).copy_(scales);
  }
  return whole;
}

at::ScalarType token_type(LinearForm form) { return token_bytes(form) == 2 ? at::kBFloat16 : at::kFloat; }

Linear::Linear(const at::Tensor& weight, const at::Tensor& bias, LinearForm form) : out_(weight.size(0)), form_(form) {
  if (is_int8(form)) {
    hold(quantised(weight));
  } else {
    // Rounding to bfloat16 is worth it only where it saves room; the multiplication in bfloat16 wants nothing else.
    const bool round = form == LinearForm::bf16 || (form == LinearForm::bf16_stored && weight.element_size() > 2);
    weight_ = round ? weight.to(at::kBFloat16) : weight;
  }
  set_bias(bias);
}

Linear::Linear(const QuantisedWeight& weight, const at::Tensor& bias, LinearForm form)
    : out_(weight.numbers.size(0)), form_(form) {
  hold(weight);
  if (form == LinearForm::bf16) {
    at::Tensor wide = at::empty(weight.numbers.sizes(), weight.numbers.options().dtype(at::kBFloat16));
    for (std::int64_t begin = 0, step = rows_at_once(weight_); begin < out_; begin += step)
      wide.slice(0, begin, std::min(begin + step, out_)).copy_(widened(begin, std::min(begin + step, out_)));
    weight_ = wide;
    scales_ = at::Tensor();
  }
  set_bias(bias);
}

void Linear::hold(const QuantisedWeight& weight) {
  // Off the CPU the same products are made of widened weights: no faster than int8_stored, the same answer.
  packed_ = form_ == LinearForm::int8 && weight.numbers.is_cpu() && int8_product_is_exact();
  weight_ = packed_ ? pack_int8(weight.numbers) : weight.numbers;
  scales_ = weight.scales;
}

/// Always a copy: in a mapped file, the few numbers would keep pages of up to 2 MB around them in memory.
void Linear::set_bias(const at::Tensor& bias) {
  if (bias.defined())
    bias_ = bias.to(form_ == LinearForm::bf16 ? at::kBFloat16 : at::kFloat, /*non_blocking=*/false, /*copy=*/true);
}

Linear::Linear(const WeightFiles& weights, const std::string& prefix, LinearForm form) {
  const std::string weight = prefix + ".weight";
  const at::Tensor bias = weights.has(prefix + ".bias") ? weights.view(prefix + ".bias") : at::Tensor();
  *this = weights.is_quantised(weight) ? Linear(weights.quantised(weight), bias, form)
                                       : Linear(weights.view(weight), bias, form);
}

LinearInput Linear::prepare(const at::Tensor& x) const {
  const at::Tensor rows = x.reshape({-1, x.size(-1)}).contiguous();
  if (form_ == LinearForm::int8) {
    auto [numbers, scales] = quantise_rows(rows);
    return {packed_ ? int8_tokens(numbers) : numbers, scales, x.scalar_type()};
  }
  return {rows.to(token_type(form_)), {}, x.scalar_type()};
}

at::Tensor Linear::operator()(const LinearInput& input) const {
  if (form_ == LinearForm::int8) {
    // Products of 8-bit numbers are exact in float32 too.
    at::Tensor y = packed_ ? int8_product(input.x, weight_, scales_, input.type)
                           : multiply_widened(input.x.to(at::kFloat), {}).to(input.type);
    scale_rows(y, input.scales, bias_);
    return y;
  }
  if (form_ == LinearForm::bf16) return at::linear(input.x, weight_, bias_).to(input.type);
  if (weight_.scalar_type() == at::kFloat) return at::linear(input.x, weight_, bias_).to(input.type);
  return multiply_widened(input.x, bias_).to(input.type);
}

at::Tensor Linear::operator()(const at::Tensor& x) const {
  std::vector<std::int64_t> shape = x.sizes().vec();
  shape.back() = out_;
  return (*this)(prepare(x)).view(shape);
}

/// Rows of the weight as float32.
at::Tensor Linear::widened(std::int64_t begin, std::int64_t end) const {
  at::Tensor rows = weight_.slice(0, begin, end).to(at::kFloat);
  if (scales_.defined()) rows.mul_(scales_.slice(0, begin, end).unsqueeze(1));
  return rows;
}

at::Tensor Linear::multiply_widened(const at::Tensor& x, const at::Tensor& bias) const {
  at::Tensor y = at::empty({x.size(0), out_}, x.options());
  const std::int64_t step = rows_at_once(weight_);
  for (std::int64_t begin = 0; begin < out_; begin += step) {
    const std::int64_t end = std::min(begin + step, out_);
    at::Tensor part = y.slice(1, begin, end);
    if (bias.defined())
      at::addmm_out(part, bias.slice(0, begin, end), x, widened(begin, end).t());
    else
      at::mm_out(part, x, widened(begin, end).t());
  }
  return y;
}

}  // namespace uwv::model
