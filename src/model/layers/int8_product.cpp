// SPDX-License-Identifier: Apache-2.0
#include "model/layers/int8_product.h"

#include <ATen/ATen.h>
#include <ATen/core/dispatch/Dispatcher.h>

#include "uwv/core/processor.h"

namespace uwv::model {
namespace {

/// torch has no C++ function for these operators of oneDNN's; they are called by name, their arguments in order.
at::Tensor call(const char* name, std::vector<c10::IValue> arguments) {
  c10::Dispatcher::singleton().findSchemaOrThrow(name, "").callBoxed(arguments);
  return arguments.front().toTensor();
}

/// Without tiles the units multiply unsigned numbers by signed ones, and the library has nothing but a plain loop for
/// weights packed this way and signed tokens, a thousand times slower. Moved up by 128 they are the same numbers, with
/// that as their zero.
bool signed_tokens() {
  static const bool tiles = processor_units().amx_int8;
  return tiles;
}

}  // namespace

bool int8_product_is_exact() {
  static const bool exact = [] {
    constexpr std::int64_t width = 64, largest = 127;
    const at::Tensor numbers = at::full({1, width}, largest, at::kChar);
    const at::Tensor sum = int8_product(int8_tokens(numbers.clone()), pack_int8(numbers), at::ones({1}), at::kFloat);
    return sum.item<float>() == static_cast<float>(largest * largest * width);
  }();
  return exact;
}

at::Tensor pack_int8(const at::Tensor& weight) {
  return call("onednn::qlinear_prepack", {weight.contiguous(), c10::IValue()});
}

at::Tensor int8_tokens(const at::Tensor& numbers) {
  return signed_tokens() ? numbers : numbers.view(at::kByte).bitwise_xor_(0x80);
}

at::Tensor int8_product(const at::Tensor& x, const at::Tensor& packed, const at::Tensor& scales, at::ScalarType type) {
  // For answers in bfloat16 the library has but a plain loop, too, where vectors are short.
  static const bool wide = processor_units().avx512;
  const at::ScalarType made = wide ? type : at::kFloat;
  const at::Tensor zero_points = at::zeros({scales.numel()}, at::kLong);
  const c10::List<std::optional<c10::Scalar>> no_arguments;
  return call("onednn::qlinear_pointwise",
              {x, /*x_scale=*/1.0, /*x_zero_point=*/signed_tokens() ? 0 : 128, packed, scales, zero_points,
               /*bias=*/c10::IValue(), /*output_scale=*/1.0, /*output_zero_point=*/0, static_cast<std::int64_t>(made),
               "none", no_arguments, ""})
      .to(type);
}

}  // namespace uwv::model
