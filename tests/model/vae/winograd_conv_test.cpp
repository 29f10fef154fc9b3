// SPDX-License-Identifier: Apache-2.0
#include "model/vae/winograd_conv.h"

#include <gtest/gtest.h>

#include "model/layers/torch_scope.h"
#include "model/tensor_support.h"
#include "model/vae/frame_doubling.h"

namespace uwv::model {
namespace {

using uwv::testing::near;

/// (h, w, C) in float64.
at::Tensor plain(const std::vector<winograd::Term>& terms, const at::Tensor& bias, bool twice) {
  at::Tensor sum = bias.defined() ? bias.to(at::kDouble).view({-1, 1, 1}) : at::zeros({1}, at::kDouble);
  for (const winograd::Term& term : terms) {
    const at::Tensor frame = twice ? doubled(term.frame) : term.frame;
    const at::Tensor picture = frame.permute({2, 0, 1}).unsqueeze(0).to(at::kDouble);
    sum = sum + at::conv2d(picture, term.weight.to(at::kDouble), {}, 1, 1)[0];
  }
  return sum.permute({1, 2, 0}).contiguous();
}

struct Problem {
  std::int64_t height = 0, width = 0, channels = 0, outputs = 0;
  std::size_t terms = 1;
  bool twice = false;

  std::vector<winograd::Term> random(double scale = 1) const {
    std::vector<winograd::Term> all;
    const double spread = 1 / std::sqrt(9.0 * static_cast<double>(channels) * static_cast<double>(terms));
    for (std::size_t i = 0; i < terms; ++i)
      all.push_back({at::randn({height, width, channels}) * scale,
                     winograd::laid_out(at::randn({outputs, channels, 3, 3}) * spread)});
    return all;
  }
  at::Tensor result() const { return at::empty({twice ? 2 * height : height, twice ? 2 * width : width, outputs}); }
};

class WinogradConv : public ::testing::Test {
 protected:
  WinogradConv() { at::manual_seed(3); }
  FramePool pool_{at::kFloat};
  TorchScope scope_{2};
};

TEST_F(WinogradConv, GivesThePlainSumAtEverySize) {
  for (const auto& [height, width] : {std::pair{1, 1}, {1, 9}, {7, 1}, {3, 5}, {4, 4}, {5, 8}, {13, 22}, {40, 33}})
    for (const std::size_t terms : {1, 2, 3})
      for (const bool twice : {false, true}) {
        const Problem problem{height, width, 32, 16, terms, twice};
        const auto inputs = problem.random();
        const at::Tensor bias = at::randn({16});
        at::Tensor ours = problem.result();
        winograd::convolve(pool_, ours, inputs, bias, false, twice);
        EXPECT_TRUE(near(ours, plain(inputs, bias, twice), 2e-5)) << height << "x" << width << " " << terms << twice;
        winograd::convolve(pool_, ours, inputs, {}, true, twice);
        EXPECT_TRUE(near(ours, 2 * plain(inputs, bias, twice) - bias, 4e-5)) << height << "x" << width;
      }
}

TEST_F(WinogradConv, ABandOfRowsIsThatPartOfTheWhole) {
  for (const bool twice : {false, true}) {
    const Problem problem{23, 18, 32, 16, 2, twice};
    const auto inputs = problem.random();
    at::Tensor whole = problem.result();
    winograd::convolve(pool_, whole, inputs, {}, false, twice);
    const std::int64_t scale = twice ? 2 : 1, first = scale * 7 + 1;
    auto band = inputs;
    for (winograd::Term& term : band) term.frame = term.frame.narrow(0, 7, 9);
    at::Tensor ours = whole.narrow(0, first, scale * 9 - 2).clone().zero_();
    winograd::convolve(pool_, ours, band, {}, false, twice, 1);
    EXPECT_TRUE(near(ours, whole.narrow(0, first, scale * 9 - 2), 2e-5)) << twice;
  }
}

TEST_F(WinogradConv, ErrorsAtTheNetworksWidthsAreFarBelowThePartsTolerance) {
  for (const std::int64_t channels : {96, 192, 384}) {
    const Problem problem{24, 40, channels, channels, 3, false};
    const auto inputs = problem.random();
    at::Tensor ours = problem.result();
    winograd::convolve(pool_, ours, inputs, {}, false);
    EXPECT_TRUE(near(ours, plain(inputs, {}, false), 2e-5)) << channels;
  }
}

TEST_F(WinogradConv, ErrorsGoWithTheSizeOfTheNumbersAround) {
  const Problem problem{12, 12, 32, 32, 3, false};
  for (const double scale : {1e-6, 1e4, 1e15}) {
    const auto inputs = problem.random(scale);
    at::Tensor ours = problem.result();
    winograd::convolve(pool_, ours, inputs, {}, false);
    EXPECT_TRUE(near(ours / scale, plain(inputs, {}, false) / scale, 2e-5)) << scale;
  }
  // One huge number spoils its own and the neighbouring tiles, no others.
  auto inputs = problem.random();
  inputs[0].frame[5][5][3] = 1e6;
  at::Tensor ours = problem.result();
  winograd::convolve(pool_, ours, inputs, {}, false);
  const at::Tensor error = (ours - plain(inputs, {}, false)).abs().amax(2);
  EXPECT_LT(error.max().item<double>(), 1e6 * 2e-5);
  EXPECT_LT(error.slice(0, 8).max().item<double>(), 2e-5);
  EXPECT_LT(error.slice(1, 8).max().item<double>(), 2e-5);
}

TEST_F(WinogradConv, WhatIsNoNumberStaysNone) {
  const Problem problem{9, 9, 16, 16, 1, false};
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    const auto inputs = problem.random();
    inputs[0].frame[4][4][0] = bad;
    at::Tensor ours = problem.result();
    winograd::convolve(pool_, ours, inputs, {}, false);
    EXPECT_FALSE(at::isfinite(ours[4][4]).any().item<bool>());
  }
}

TEST_F(WinogradConv, ThreadsChangeRoundingAtMost) {
  const Problem problem{50, 70, 32, 16, 3, false};
  const auto inputs = problem.random();
  at::Tensor two = problem.result(), one = problem.result();
  winograd::convolve(pool_, two, inputs, {}, false);
  const TorchScope scope(1);
  winograd::convolve(pool_, one, inputs, {}, false);
  EXPECT_TRUE(near(one, two, 1e-5));
}

TEST_F(WinogradConv, IsLeftToWeightsAndPicturesItPaysFor) {
  const auto weight = [](std::int64_t outputs, std::int64_t channels, std::int64_t side) {
    return at::zeros({outputs, channels, side, side});
  };
  EXPECT_TRUE(winograd::pays(1024));
  EXPECT_FALSE(winograd::pays(1000));
  EXPECT_TRUE(winograd::takes(weight(96, 96, 3)));
  EXPECT_FALSE(winograd::takes(weight(96, 96, 1)));
  EXPECT_FALSE(winograd::takes(weight(3, 96, 3)));
  EXPECT_FALSE(winograd::takes(weight(96, 3, 3)));
  EXPECT_FALSE(winograd::takes(weight(96, 96, 3).to(at::kBFloat16)));
}

}  // namespace
}  // namespace uwv::model
