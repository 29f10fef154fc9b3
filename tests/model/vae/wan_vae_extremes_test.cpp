// SPDX-License-Identifier: Apache-2.0
// Inputs at the edge of what makes sense: an answer without NaN, or an error that says where.
#include <ATen/CPUGeneratorImpl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "model/complaint.h"
#include "model/layers/torch_scope.h"
#include "model/tensor_support.h"
#include "model/vae/wan_vae.h"
#include "support/matchers.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

using ::testing::HasSubstr;
using uwv::testing::complaint;
using uwv::testing::fixture_folder;
using uwv::testing::near;

class WanVaeExtremes : public ::testing::TestWithParam<VaePrecision> {
 protected:
  WanVae open(int bands = 1) const {
    VaeOptions options;
    options.precision = GetParam();
    options.bands = bands;
    return WanVae::open(fixture_folder("vae"), options);
  }
  static at::Tensor random(at::IntArrayRef sizes) {
    return at::randn(sizes, at::detail::createCPUGenerator(5), at::TensorOptions(at::kFloat));
  }

  TorchScope scope_{1};
  Monitor monitor_;
};

TEST_P(WanVaeExtremes, OneLatentIsAPicture) {
  const WanVae vae = open(8);
  const at::Tensor decoded = vae.decode(random({1, vae.config().z_dim, 1, 1, 1}), monitor_);
  const std::int64_t side = vae.config().spatial_factor();
  EXPECT_EQ(decoded.sizes(), (std::vector<std::int64_t>{1, 3, 1, side, side}));
  EXPECT_TRUE(at::isfinite(decoded).all().item<bool>());
  EXPECT_EQ(vae.encode(decoded, monitor_).sizes(), (std::vector<std::int64_t>{1, vae.config().z_dim, 1, 1, 1}));
}

TEST_P(WanVaeExtremes, BandsGiveTheSameAsOnePiece) {
  const double tolerance = GetParam() == VaePrecision::f32 ? 1e-5 : 0.05;
  const WanVae whole = open();
  for (const std::int64_t rows : {1, 3, 14}) {
    const at::Tensor latents = random({1, whole.config().z_dim, 3, rows, 2});
    const at::Tensor decoded = whole.decode(latents, monitor_);
    const at::Tensor encoded = whole.encode(decoded, monitor_);
    for (const int bands : {2, 5, 64}) {
      SCOPED_TRACE(::testing::Message() << rows << " rows of latents, bands " << bands);
      const WanVae vae = open(bands);
      EXPECT_TRUE(near(vae.decode(latents, monitor_), decoded, tolerance));
      EXPECT_TRUE(near(vae.encode(decoded, monitor_), encoded, tolerance));
    }
  }
}

TEST_P(WanVaeExtremes, ConstantPicturesAndHugeLatentsStayFinite) {
  const WanVae vae = open();
  for (const double value : {-1.0, 0.0, 1.0})
    EXPECT_TRUE(at::isfinite(vae.encode(at::full({1, 3, 5, 16, 24}, value), monitor_)).all().item<bool>()) << value;
  EXPECT_TRUE(at::isfinite(vae.decode(at::zeros({1, vae.config().z_dim, 2, 2, 3}), monitor_)).all().item<bool>());
  const at::Tensor huge = 1e6 * random({1, vae.config().z_dim, 2, 2, 3});
  const at::Tensor decoded = vae.decode(huge, monitor_);
  EXPECT_TRUE(at::isfinite(decoded).all().item<bool>());
  EXPECT_LE(decoded.abs().max().item<double>(), 1);
}

TEST_P(WanVaeExtremes, WhatIsNotFiniteIsNamed) {
  const WanVae vae = open();
  at::Tensor latents = random({1, vae.config().z_dim, 2, 2, 3});
  latents[0][0][1][0][0] = NAN;
  EXPECT_THAT(complaint([&] { vae.decode(latents, monitor_); }, ErrorCode::value_invalid), HasSubstr("NaN"));
  EXPECT_THAT(complaint(
                  [&] {
                    vae.encode(at::full({1, 3, 1, 16, 16}, HUGE_VAL), monitor_);
                  },
                  ErrorCode::value_invalid),
              HasSubstr("pictures to encode"));
  // Finite, but too large to be squared: the layer that meets it is named.
  EXPECT_THAT(complaint(
                  [&] {
                    vae.decode(at::full({1, vae.config().z_dim, 1, 2, 2}, 1e30), monitor_);
                  },
                  ErrorCode::value_invalid),
              HasSubstr("decoder.mid_block.resnets.0.norm1"));
}

TEST_P(WanVaeExtremes, SizesThatDoNotFitAreRefused) {
  const WanVae vae = open();
  EXPECT_THAT(complaint(
                  [&] {
                    vae.encode(at::zeros({1, 3, 1, 12, 16}), monitor_);
                  },
                  ErrorCode::size_mismatch),
              HasSubstr("multiples of 8"));
  complaint([&] { vae.encode(at::zeros({1, 4, 1, 16, 16}), monitor_); }, ErrorCode::size_mismatch);
  complaint([&] { vae.decode(at::zeros({1, 3, 1, 2, 2}), monitor_); }, ErrorCode::size_mismatch);
  VaeOptions options;
  options.bands = 0;
  EXPECT_THROW(WanVae::open(fixture_folder("vae"), options), std::invalid_argument);
}

TEST_P(WanVaeExtremes, TheSameInputGivesTheSameBytesAndThreadsNearlySo) {
  const WanVae vae = open();
  const at::Tensor latents = random({1, vae.config().z_dim, 2, 3, 4});
  const at::Tensor once = vae.decode(latents, monitor_);
  EXPECT_TRUE(at::equal(once, vae.decode(latents, monitor_)));
  const TorchScope two(2);
  EXPECT_TRUE(near(vae.decode(latents, monitor_), once, GetParam() == VaePrecision::f32 ? 1e-5 : 0.05));
}

TEST_P(WanVaeExtremes, AClipStopsBetweenBlocks) {
  class Impatient : public Monitor {
   public:
    bool progress(std::string_view, long, long) override { return ++calls < 6; }
    int calls = 0;
  };
  const WanVae vae = open();
  Impatient impatient;
  long shown = 0;
  const auto sink = [&](std::int64_t, const at::Tensor&) { ++shown; };
  complaint([&] { vae.decode(random({1, vae.config().z_dim, 3, 2, 2}), sink, impatient); }, ErrorCode::cancelled);
  EXPECT_EQ(impatient.calls, 6);
  EXPECT_EQ(shown, 0);
}

INSTANTIATE_TEST_SUITE_P(Precisions, WanVaeExtremes, ::testing::Values(VaePrecision::f32, VaePrecision::bf16),
                         [](const auto& precision) { return std::string(to_string(precision.param)); });

}  // namespace
}  // namespace uwv::model
