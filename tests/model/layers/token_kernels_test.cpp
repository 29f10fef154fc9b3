// SPDX-License-Identifier: Apache-2.0
#include "model/layers/token_kernels.h"

#include <ATen/ATen.h>
#include <gtest/gtest.h>

#include <limits>

#include "model/layers/torch_scope.h"
#include "model/tensor_support.h"

namespace uwv::model {
namespace {

using uwv::testing::near;

/// One width that fills the lanes and one that doesn't.
constexpr std::array widths{64, 52};

class TokenKernels : public ::testing::TestWithParam<int> {
 protected:
  TokenKernels() : scope_(2) { at::manual_seed(3); }
  int width() const { return GetParam(); }
  at::Tensor tokens() const { return at::randn({2, 33, width()}) * 3 + 1; }
  TorchScope scope_;
};

TEST_P(TokenKernels, LayerNormIsTorchsWithScalesPerBatchItem) {
  const at::Tensor x = tokens(), scale = at::randn({2, width()}), shift = at::randn({2, width()});
  const at::Tensor want = at::layer_norm(x, {width()}, {}, {}, 1e-6) * scale.unsqueeze(1) + shift.unsqueeze(1);
  EXPECT_TRUE(near(layer_norm(x, scale, shift, 1e-6, at::kFloat), want, 2e-5));
  EXPECT_TRUE(near(layer_norm(x, scale, shift, 1e-6, at::kBFloat16), want, 0.06));
  const at::Tensor flat = layer_norm(x, scale[0], shift[0], 1e-6, at::kFloat);
  EXPECT_TRUE(at::equal(flat[0], layer_norm(x, scale, shift, 1e-6, at::kFloat)[0]));
}

TEST_P(TokenKernels, GatesAreAddedInPlace) {
  const at::Tensor y = tokens(), gate = at::randn({2, width()});
  at::Tensor x = tokens();
  const at::Tensor before = x.clone();
  add_gated(x, y, gate);
  EXPECT_TRUE(near(x, before + y * gate.unsqueeze(1), 1e-5));
  add_gated(x, y.to(at::kBFloat16), {});
  EXPECT_TRUE(near(x, before + y * gate.unsqueeze(1) + y.to(at::kBFloat16).to(at::kFloat), 1e-5));
}

TEST_P(TokenKernels, RmsNormAndTurnAreTheSumsByHand) {
  const int head = width() / 2, pairs = head / 2;
  const at::Tensor x = tokens(), weight = at::randn({width()});
  const at::Tensor angle = at::randn({33, pairs});
  at::Tensor ours = x.clone();
  rms_norm_rotate(ours, weight, 1e-6, at::cos(angle), at::sin(angle));
  const at::Tensor normed = x * at::rsqrt(x.square().mean(-1, true) + 1e-6) * weight;
  const at::Tensor parts = normed.view({2, 33, 2, head / 2, 2});
  const at::Tensor a = parts.select(-1, 0), b = parts.select(-1, 1);
  const at::Tensor c = at::cos(angle).view({1, 33, 1, pairs}), s = at::sin(angle).view({1, 33, 1, pairs});
  const at::Tensor want = at::stack({a * c - b * s, a * s + b * c}, -1).view(x.sizes());
  EXPECT_TRUE(near(ours, want, 2e-5));
}

TEST_P(TokenKernels, QuantisedRowsComeBackWithinHalfAStep) {
  const at::Tensor x = tokens().flatten(0, 1);
  const auto [numbers, scales] = quantise_rows(x);
  const at::Tensor steps = (numbers.to(at::kFloat) * scales.unsqueeze(1) - x).abs() / scales.unsqueeze(1);
  EXPECT_LE(steps.max().item<float>(), 0.5001F);
  EXPECT_EQ(numbers.abs().amax(1).min().item<int>(), 127);
  at::Tensor y = numbers.to(at::kFloat);
  const at::Tensor bias = at::randn({width()});
  scale_rows(y, scales, bias);
  EXPECT_TRUE(near(y, numbers.to(at::kFloat) * scales.unsqueeze(1) + bias, 1e-6));
}

TEST_P(TokenKernels, RowsWithoutVarianceStayFinite) {
  const at::Tensor one = at::ones({width()}), none = at::zeros({width()});
  for (const double value : {0.0, 5.0}) {
    at::Tensor x = at::full({1, 2, width()}, value);
    EXPECT_TRUE(all_finite(layer_norm(x, one, none, 1e-6, at::kFloat)));
    rms_norm_rotate(x, one, 1e-6, {}, {});
    EXPECT_TRUE(all_finite(x));
    const auto [numbers, scales] = quantise_rows(at::full({2, width()}, value));
    EXPECT_TRUE(near(numbers.to(at::kFloat) * scales.unsqueeze(1), at::full({2, width()}, value), 1e-5));
  }
}

TEST_P(TokenKernels, OneBadNumberIsFound) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    at::Tensor x = tokens();
    EXPECT_TRUE(all_finite(x));
    x[1][32][width() - 1] = bad;
    EXPECT_FALSE(all_finite(x));
    EXPECT_FALSE(all_finite(x.to(at::kBFloat16)));
  }
}

TEST_P(TokenKernels, ThreadsDoNotChangeABit) {
  const at::Tensor x = tokens(), scale = at::randn({2, width()}), shift = at::randn({2, width()});
  const at::Tensor two = layer_norm(x, scale, shift, 1e-6, at::kBFloat16);
  const TorchScope scope(1);
  EXPECT_TRUE(at::equal(two, layer_norm(x, scale, shift, 1e-6, at::kBFloat16)));
}

INSTANTIATE_TEST_SUITE_P(Widths, TokenKernels, ::testing::ValuesIn(widths));

}  // namespace
}  // namespace uwv::model
