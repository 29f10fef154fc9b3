// SPDX-License-Identifier: Apache-2.0
// The ways off the CPU, forced on it and held against the CPU's own.
#include "model/layers/token_formulas.h"

#include <ATen/ATen.h>
#include <gtest/gtest.h>

#include <limits>

#include "model/layers/token_kernels.h"
#include "model/layers/torch_scope.h"
#include "model/tensor_support.h"

namespace uwv::model {
namespace {

using uwv::testing::near;

class TokenFormulas : public ::testing::TestWithParam<at::ScalarType> {
 protected:
  TokenFormulas() : scope_(2) { at::manual_seed(8); }
  at::Tensor tokens() const { return (at::randn({2, 9, 24}) * 3 + 1).to(GetParam()); }
  /// Of values of about 10: float32's rounding, or bfloat16's last bit.
  double tolerance() const { return GetParam() == at::kFloat ? 1e-5 : 0.07; }
  TorchScope scope_;
};

TEST_P(TokenFormulas, NormsEqualTheKernels) {
  const at::Tensor x = tokens(), scale = at::randn({2, 24}), shift = at::randn({2, 24});
  for (const at::ScalarType type : {at::kFloat, at::kBFloat16})
    EXPECT_TRUE(near(formula::layer_norm(x, scale, shift, 1e-6, type), layer_norm(x, scale, shift, 1e-6, type),
                     type == at::kFloat ? 1e-5 : 0.07));
  EXPECT_TRUE(near(formula::layer_norm(x, scale[0], shift[0], 1e-6, at::kFloat),
                   layer_norm(x, scale[0], shift[0], 1e-6, at::kFloat), 1e-5));
  const at::Tensor angles = at::randn({9, 6});
  for (const bool turn : {false, true}) {
    const at::Tensor cosine = turn ? at::cos(angles) : at::Tensor(), sine = turn ? at::sin(angles) : at::Tensor();
    at::Tensor ours = x.clone(), want = x.clone();
    formula::rms_norm_rotate(ours, scale[0], 1e-6, cosine, sine);
    rms_norm_rotate(want, scale[0], 1e-6, cosine, sine);
    EXPECT_TRUE(near(ours, want, tolerance()));
  }
}

TEST_P(TokenFormulas, GatesAndScalesEqualTheKernels) {
  const at::Tensor y = tokens(), gate = at::randn({2, 24});
  for (const at::Tensor& g : {gate, gate.narrow(0, 0, 1), at::Tensor()}) {
    at::Tensor ours = at::ones({2, 9, 24}), want = at::ones({2, 9, 24});
    formula::add_gated(ours, y, g);
    add_gated(want, y, g);
    EXPECT_TRUE(near(ours, want, 1e-5));
  }
  for (const at::Tensor& bias : {gate[0], at::Tensor()}) {
    at::Tensor ours = y.flatten(0, 1).clone(), want = ours.clone();
    const at::Tensor scales = at::rand({18});
    formula::scale_rows(ours, scales, bias);
    scale_rows(want, scales, bias);
    EXPECT_TRUE(near(ours, want, tolerance()));
  }
}

TEST_P(TokenFormulas, QuantisedRowsAreTheKernelsRowsOfZerosIncluded) {
  at::Tensor x = tokens().flatten(0, 1);
  x[4].zero_();
  const auto [numbers, scales] = formula::quantise_rows(x);
  const auto [want, want_scales] = quantise_rows(x);
  EXPECT_TRUE(at::equal(numbers, want));
  EXPECT_TRUE(near(scales, want_scales, 1e-7));
}

TEST_P(TokenFormulas, WhatIsNotFiniteIsSeen) {
  at::Tensor x = tokens();
  EXPECT_TRUE(formula::all_finite(x));
  for (const double value : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    x[1][3][5] = value;
    EXPECT_FALSE(formula::all_finite(x));
  }
}

INSTANTIATE_TEST_SUITE_P(Types, TokenFormulas, ::testing::Values(at::kFloat, at::kBFloat16),
                         [](const auto& type) { return std::string(at::toString(type.param)); });

}  // namespace
}  // namespace uwv::model
