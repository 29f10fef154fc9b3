// SPDX-License-Identifier: Apache-2.0
#include "model/layers/linear.h"

#include <ATen/ATen.h>
#include <gtest/gtest.h>

#include <chrono>

#include "model/layers/token_kernels.h"
#include "model/layers/torch_scope.h"
#include "model/tensor_support.h"

namespace uwv::model {
namespace {

using uwv::testing::near;

constexpr std::array forms{LinearForm::f32, LinearForm::bf16_stored, LinearForm::bf16, LinearForm::int8_stored,
                           LinearForm::int8};

/// The error a form may have, of the answer's size.
double allowed(LinearForm form) {
  switch (form) {
    case LinearForm::f32: return 1e-6;
    case LinearForm::bf16_stored: return 0.003;
    case LinearForm::bf16: return 0.006;
    case LinearForm::int8_stored: return 0.01;
    case LinearForm::int8: return 0.015;
  }
  return 0;
}

double relative_error(const at::Tensor& ours, const at::Tensor& exact) {
  const auto rms = [](const at::Tensor& x) { return x.to(at::kDouble).square().mean().sqrt().item<double>(); };
  return rms(ours.to(at::kDouble) - exact) / rms(exact);
}

struct Case {
  at::Tensor x, weight, bias, exact;
};

/// `out` beyond what is widened at once, so that the last piece is a short one.
Case random_case(std::int64_t rows, std::int64_t in, std::int64_t out) {
  at::manual_seed(7);
  Case c{at::randn({rows, in}), at::randn({out, in}) / 8, at::randn({out}), {}};
  c.exact = at::linear(c.x.to(at::kDouble), c.weight.to(at::kDouble), c.bias.to(at::kDouble));
  return c;
}

TEST(Linear, EveryFormStaysWithinItsError) {
  const TorchScope scope(1);
  for (const auto& [rows, in, out] : {std::array<std::int64_t, 3>{37, 48, 96}, {1, 24, 5}, {3, 40000, 130}}) {
    const Case c = random_case(rows, in, out);
    double last = -1;
    for (const LinearForm form : forms) {
      const double error = relative_error(Linear(c.weight, c.bias, form)(c.x), c.exact);
      EXPECT_LT(error, allowed(form)) << to_string(form) << " " << out;
      if (form == LinearForm::f32) last = error;
      EXPECT_GE(error, last) << to_string(form) << ": better than exact";
    }
  }
}

TEST(Linear, AnswersHaveTheTypeOfWhatIsRead) {
  const TorchScope scope(1);
  const Case c = random_case(4, 16, 8);
  for (const LinearForm form : forms)
    for (const auto type : {at::kFloat, at::kBFloat16}) {
      const at::Tensor y = Linear(c.weight, c.bias, form)(c.x.to(type).view({2, 2, 16}));
      EXPECT_EQ(y.scalar_type(), type) << to_string(form);
      EXPECT_EQ(y.sizes().vec(), (std::vector<std::int64_t>{2, 2, 8}));
    }
}

TEST(Linear, WhatIsStoredInFewBitsIsMultipliedExactly) {
  const TorchScope scope(1);
  const Case c = random_case(5, 64, 96);
  for (const auto type : {at::kBFloat16, at::kHalf, at::kFloat8_e4m3fn}) {
    const at::Tensor stored = c.weight.to(type);
    const at::Tensor want = at::linear(c.x, stored.to(at::kFloat), c.bias);
    EXPECT_TRUE(near(Linear(stored, c.bias, LinearForm::f32)(c.x), want, 1e-5)) << type;
    EXPECT_TRUE(near(Linear(stored, c.bias, LinearForm::bf16_stored)(c.x), want, 1e-5)) << type;
  }
}

TEST(Linear, ZeroWeightsAndZeroTokensGiveTheBias) {
  const TorchScope scope(1);
  const at::Tensor bias = at::linspace(-1, 1, 8);
  for (const LinearForm form : forms) {
    const double rounding = token_type(form) == at::kBFloat16 ? 0.004 : 0;
    EXPECT_TRUE(near(Linear(at::zeros({8, 16}), bias, form)(at::ones({1, 16})), bias.unsqueeze(0), rounding));
    EXPECT_TRUE(near(Linear(at::ones({8, 16}), bias, form)(at::zeros({1, 16})), bias.unsqueeze(0), rounding));
  }
}

TEST(Linear, ALayerWithoutBiasIsAllowed) {
  const TorchScope scope(1);
  const Case c = random_case(3, 32, 16);
  for (const LinearForm form : forms)
    EXPECT_LT(relative_error(Linear(c.weight, {}, form)(c.x), c.exact - c.bias), 2 * allowed(form)) << to_string(form);
}

TEST(Linear, RoundingPieceByPieceIsRoundingAtOnce) {
  const TorchScope scope(1);
  const Case c = random_case(1, 40000, 130);
  for (const auto type : {at::kFloat, at::kBFloat16, at::kHalf}) {
    const at::Tensor stored = c.weight.to(type);
    const auto [numbers, scales] = quantise_rows(stored.to(at::kFloat));
    const QuantisedWeight pieces = quantised(stored);
    EXPECT_TRUE(at::equal(pieces.numbers, numbers)) << type;
    EXPECT_TRUE(at::equal(pieces.scales, scales)) << type;
  }
}

TEST(Linear, AWeightThatIs8BitAlreadyGivesTheSameBitsAsOneRoundedHere) {
  const TorchScope scope(1);
  const Case c = random_case(5, 64, 96);
  const QuantisedWeight stored = quantised(c.weight);
  for (const LinearForm form : {LinearForm::int8_stored, LinearForm::int8})
    EXPECT_TRUE(at::equal(Linear(stored, c.bias, form)(c.x), Linear(c.weight, c.bias, form)(c.x))) << to_string(form);
  const at::Tensor wide = stored.numbers.to(at::kFloat) * stored.scales.unsqueeze(1);
  for (const LinearForm form : {LinearForm::f32, LinearForm::bf16_stored, LinearForm::bf16})
    EXPECT_TRUE(near(Linear(stored, c.bias, form)(c.x), Linear(wide, c.bias, LinearForm::f32)(c.x),
                     form == LinearForm::bf16 ? 0.1 : 1e-4))
        << to_string(form);
}

// The library falls back on plain loops, a thousand times slower, for kinds of numbers the CPU's units do not take.
TEST(Linear, NoFormFallsBackOnAPlainLoop) {
  const TorchScope scope(1);
  const Case c = random_case(32, 512, 512);
  const auto seconds = [&](LinearForm form, at::ScalarType tokens) {
    const Linear layer(c.weight, c.bias, form);
    const at::Tensor x = c.x.to(tokens);
    double best = 1e9;
    for (int run = 0; run < 5; ++run) {
      const auto start = std::chrono::steady_clock::now();
      layer(x);
      best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
    return best;
  };
  const double exact = seconds(LinearForm::f32, at::kFloat);
  for (const LinearForm form : forms)
    for (const at::ScalarType tokens : {at::kFloat, at::kBFloat16})
      EXPECT_LT(seconds(form, tokens), 100 * exact) << to_string(form) << " of " << c10::toString(tokens);
}

TEST(Linear, LayersOfOneFormShareWhatTheyRead) {
  const TorchScope scope(1);
  const Case c = random_case(3, 32, 16);
  for (const LinearForm form : forms) {
    const Linear one(c.weight, c.bias, form), other(c.weight.neg(), {}, form);
    EXPECT_TRUE(at::equal(other(one.prepare(c.x)), other(c.x))) << to_string(form);
  }
}

TEST(Linear, FormsGoByTheirNames) {
  for (const LinearForm form : forms) EXPECT_EQ(linear_form(to_string(form)), form);
  EXPECT_THROW(linear_form("int4"), std::invalid_argument);
}

}  // namespace
}  // namespace uwv::model
