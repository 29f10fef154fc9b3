// SPDX-License-Identifier: Apache-2.0
#include "model/vae/fused_conv.h"

#include <ATen/ATen.h>
#include <ATen/core/dispatch/Dispatcher.h>

#include <optional>
#include <string_view>

namespace uwv::model::fused_conv {
namespace {

using Ints = at::IntArrayRef;
using MaybeScalar = std::optional<at::Scalar>;
using MaybeText = std::optional<std::string_view>;
using Run = at::Tensor(const at::Tensor&, const at::Tensor&, const std::optional<at::Tensor>&, Ints, Ints, Ints,
                       std::int64_t, std::string_view, c10::List<MaybeScalar>, MaybeText);
using Add = at::Tensor&(at::Tensor&, const at::Tensor&, const at::Tensor&, const std::optional<at::Tensor>&, Ints, Ints,
                        Ints, std::int64_t, std::string_view, MaybeScalar, MaybeText, c10::List<MaybeScalar>,
                        MaybeText);

template <class Function>
std::optional<c10::TypedOperatorHandle<Function>> find(const char* name, const char* overload) {
  const auto found = c10::Dispatcher::singleton().findSchema({name, overload});
  if (!found) return std::nullopt;
  try {
    return found->template typed<Function>();
  } catch (const c10::Error&) {
    return std::nullopt;  // Another torch, in which it takes other arguments.
  }
}

/// oneDNN refuses bfloat16 on CPUs that cannot even convert it.
bool takes_bfloat16(const c10::TypedOperatorHandle<Run>& run) {
  const at::Tensor one = at::ones({1, 1, 1, 1}, at::kBFloat16);
  try {
    run.call(one, one, std::nullopt, {0, 0}, {1, 1}, {1, 1}, 1, "none", c10::List<MaybeScalar>(), std::nullopt);
    return true;
  } catch (const c10::Error&) {
    return false;
  }
}

struct Operators {
  std::optional<c10::TypedOperatorHandle<Run>> run = find<Run>("mkldnn::_convolution_pointwise", "");
  std::optional<c10::TypedOperatorHandle<Add>> add = find<Add>("mkldnn::_convolution_pointwise_", "binary");
  bool complete = run && add && at::Context::hasMKLDNN() && at::globalContext().userEnabledMkldnn();
  bool bfloat16 = complete && takes_bfloat16(*run);

  bool take(at::ScalarType type) const { return type == at::kBFloat16 ? bfloat16 : complete; }
};

const Operators& operators() {
  static const Operators found;
  return found;
}

at::Tensor plain_conv(const at::Tensor& x, const at::Tensor& weight, const at::Tensor& bias, const Steps& steps) {
  const auto widened = [](const at::Tensor& t) { return t.defined() ? t.to(at::kFloat) : t; };
  return at::conv2d(widened(x), widened(weight), widened(bias), {steps.stride, steps.stride},
                    {steps.rows, steps.columns})
      .to(x.scalar_type());
}

std::optional<at::Tensor> maybe(const at::Tensor& tensor) {
  return tensor.defined() ? std::optional(tensor) : std::nullopt;
}

}  // namespace

at::Tensor run(const at::Tensor& x, const at::Tensor& weight, const at::Tensor& bias, const Steps& steps) {
  if (!x.is_cpu()) return at::conv2d(x, weight, maybe(bias), {steps.stride, steps.stride}, {steps.rows, steps.columns});
  if (!operators().take(x.scalar_type())) return plain_conv(x, weight, bias, steps);
  return operators().run->call(x, weight, maybe(bias), {steps.rows, steps.columns}, {steps.stride, steps.stride},
                               {1, 1}, 1, "none", c10::List<MaybeScalar>(), std::nullopt);
}

void add(at::Tensor& sum, const at::Tensor& x, const at::Tensor& weight, const at::Tensor& bias, const Steps& steps) {
  if (!x.is_cpu() || !operators().take(x.scalar_type())) {
    sum.add_(x.is_cpu() ? plain_conv(x, weight, bias, steps) : run(x, weight, bias, steps));
    return;
  }
  operators().add->call(sum, x, weight, maybe(bias), {steps.rows, steps.columns}, {steps.stride, steps.stride}, {1, 1},
                        1, "add", std::nullopt, std::nullopt, c10::List<MaybeScalar>(), std::nullopt);
}

}  // namespace uwv::model::fused_conv
