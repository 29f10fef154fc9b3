// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/machine_speed.h"

#include <ATen/ATen.h>

#include <algorithm>
#include <chrono>

#include "model/layers/linear.h"
#include "model/vae/frame_conv.h"

namespace uwv::model {
namespace {

/// Long enough to even out, short enough that a plan is there at once.
constexpr double measured_seconds = 0.2;
/// Beyond these sizes speed no longer changes, and weights would take long to make.
constexpr std::int64_t most_width = 2048, most_tokens = 2048;

/// Calls a second. Devices other than the CPU answer before they have worked, so a number of each answer is fetched.
template <class Work>
double rate(const Work& done) {
  const auto work = [&] {
    const at::Tensor answer = done();
    if (!answer.is_cpu()) answer.flatten()[0].item();
  };
  work();  // the first call sets the library up
  const auto start = std::chrono::steady_clock::now();
  std::chrono::duration<double> passed{};
  int calls = 0;
  do {
    work();
    ++calls;
    passed = std::chrono::steady_clock::now() - start;
  } while (passed.count() < measured_seconds);
  return calls / passed.count();
}

}  // namespace

double linear_speed(LinearForm form, std::int64_t width, c10::Device device) {
  constexpr std::int64_t tokens = 1024;
  const std::int64_t side = std::min(width, most_width);
  const Linear layer(at::full({side, side}, 0.01, at::TensorOptions(device)), {}, form);
  const at::Tensor x = at::ones({tokens, side}, at::TensorOptions(device).dtype(token_type(form)));
  return 2.0 * static_cast<double>(tokens * side * side) * rate([&] { return layer(x); });
}

double attention_speed(LinearForm form, std::int64_t head_dim, std::int64_t tokens, c10::Device device) {
  constexpr std::int64_t heads = 4;
  const std::int64_t n = std::clamp<std::int64_t>(tokens, 64, most_tokens);
  const at::Tensor x = at::ones({1, heads, n, head_dim}, at::TensorOptions(device).dtype(token_type(form)));
  return 4.0 * static_cast<double>(heads * n * n * head_dim) *
         rate([&] { return at::scaled_dot_product_attention(x, x, x); });
}

double convolution_speed(VaePrecision precision, c10::Device device, std::int64_t channels) {
  constexpr std::int64_t side = 96, kernel = 3;
  const auto type = resolved(precision) == VaePrecision::bf16 ? at::kBFloat16 : at::kFloat;
  const at::TensorOptions options = at::TensorOptions(device).dtype(type);
  const FrameConv conv(at::full({channels, channels, kernel, kernel}, 0.01, options), {}, FrameConv::Edge::same);
  const at::Tensor frame = at::ones({side, side, channels}, options);
  const FramePool pool(type, device);
  return 2.0 * static_cast<double>(side * side * channels * channels * kernel * kernel) *
         rate([&] { return conv(frame, pool); });
}

double rounding_speed(LinearForm form, int stored_bytes, std::int64_t width, c10::Device device) {
  const std::int64_t side = std::min(width, most_width);
  const at::Tensor weight =
      at::full({side, side}, 0.01, at::TensorOptions(device)).to(stored_bytes == 4 ? at::kFloat : at::kBFloat16);
  if (stored_bytes == 1) {
    const QuantisedWeight stored = quantised(weight);
    return static_cast<double>(side * side) * rate([&] {
             const Linear layer(stored, {}, form);
             return at::Tensor(weight);
           });
  }
  return static_cast<double>(side * side) * rate([&] {
           const Linear layer(weight, {}, form);
           return at::Tensor(weight);
         });
}

}  // namespace uwv::model
