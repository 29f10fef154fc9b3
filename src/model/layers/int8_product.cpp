// SPDX-License-Identifier: Apache-2.0
#include "model/layers/int8_product.h"

#include <ATen/ATen.h>
#include <ATen/core/dispatch/Dispatcher.h>

namespace uwv::model {
namespace {

/// torch has no C++ function for these operators of oneDNN's; they are called by name, their arguments in order.
at::Tensor call(const char* name, std::vector<c10::IValue> arguments) {
  c10::Dispatcher::singleton().findSchemaOrThrow(name, "").callBoxed(arguments);
  return arguments.front().toTensor();
}

}  // namespace

bool int8_product_is_exact() {
  static const bool exact = [] {
    constexpr std::int64_t width = 64, largest = 127;
    const at::Tensor numbers = at::full({1, width}, largest, at::kChar);
    const at::Tensor sum = int8_product(numbers, pack_int8(numbers), at::ones({1}), at::kFloat);
    return sum.item<float>() == static_cast<float>(largest * largest * width);
  }();
  return exact;
}

at::Tensor pack_int8(const at::Tensor& weight) {
  return call("onednn::qlinear_prepack", {weight.contiguous(), c10::IValue()});
}

at::Tensor int8_product(const at::Tensor& x, const at::Tensor& packed, const at::Tensor& scales, at::ScalarType type) {
  const at::Tensor zero_points = at::zeros({scales.numel()}, at::kLong);
  const c10::List<std::optional<c10::Scalar>> no_arguments;
  return call(
      "onednn::qlinear_pointwise",
      {x, /*x_scale=*/1.0, /*x_zero_point=*/0, packed, scales, zero_points, /*bias=*/c10::IValue(),
       /*output_scale=*/1.0, /*output_zero_point=*/0, static_cast<std::int64_t>(type), "none", no_arguments, ""});
}

}  // namespace uwv::model
