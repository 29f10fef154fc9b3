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

struct Operators {
  std::optional<c10::TypedOperatorHandle<Run>> run = find<Run>("mkldnn::_convolution_pointwise", "");
  std::optional<c10::TypedOperatorHandle<Add>> add = find<Add>("mkldnn::_convolution_pointwise_", "binary");
  bool complete = run && add && at::globalContext().hasMKLDNN() && at::globalContext().userEnabledMkldnn();
};

const Operators& operators() {
  static const Operators found;
  return found;
}

std::optional<at::Tensor> maybe(const at::Tensor& tensor) {
  return tensor.defined() ? std::optional(tensor) : std::nullopt;
}

}  // namespace

at::Tensor run(const at::Tensor& x, const at::Tensor& weight, const at::Tensor& bias, std::int64_t padding,
               std::int64_t stride) {
  if (!operators().complete) return at::conv2d(x, weight, bias, stride, padding);
  return operators().run->call(x, weight, maybe(bias), {padding, padding}, {stride, stride}, {1, 1}, 1, "none",
                               c10::List<MaybeScalar>(), std::nullopt);
}

void add(at::Tensor& sum, const at::Tensor& x, const at::Tensor& weight, const at::Tensor& bias, std::int64_t padding,
         std::int64_t stride) {
  if (!operators().complete) {
    sum.add_(at::conv2d(x, weight, bias, stride, padding));
    return;
  }
  operators().add->call(sum, x, weight, maybe(bias), {padding, padding}, {stride, stride}, {1, 1}, 1, "add",
                        std::nullopt, std::nullopt, c10::List<MaybeScalar>(), std::nullopt);
}

}  // namespace uwv::model::fused_conv
