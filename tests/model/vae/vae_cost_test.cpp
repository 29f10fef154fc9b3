// SPDX-License-Identifier: Apache-2.0
#include "model/vae/vae_cost.h"

#include <gtest/gtest.h>

namespace uwv::model {
namespace {

// By hand, from the paper sizes: a full-size convolution of the last level is 2 * 27 * 96 * 96 operations a pixel.
TEST(VaeCost, OperationsOfARealDecodeAreThoseOfItsConvolutions) {
  const VaeConfig config;
  const VaeOptions options;
  const double four = estimated_flops(config, {5, 480, 832}, options, VaeWay::decode) -
                      estimated_flops(config, {1, 480, 832}, options, VaeWay::decode);
  const double last_level = 6 * 4 * 2.0 * 27 * 96 * 96 * 480 * 832;
  EXPECT_GT(four, 2.2 * last_level);
  EXPECT_LT(four, 3.2 * last_level);
}

// Peaks of a process that did nothing else (`uwv_bench model vae`, one form a run).
TEST(VaeCost, PeaksAreWithinAFifthOfTheMeasuredOnes) {
  struct Measured {
    ClipSize size;
    VaePrecision precision;
    int bands;
    VaeWay way;
    double gigabytes;
  };
  const Measured all[] = {{{5, 240, 416}, VaePrecision::f32, 1, VaeWay::decode, 1.73},
                          {{5, 240, 416}, VaePrecision::f32, 4, VaeWay::decode, 1.02},
                          {{5, 240, 416}, VaePrecision::f32, 8, VaeWay::decode, 0.83},
                          {{9, 240, 416}, VaePrecision::f32, 6, VaeWay::decode, 0.93},
                          {{5, 480, 832}, VaePrecision::f32, 8, VaeWay::decode, 1.43},
                          {{5, 240, 416}, VaePrecision::bf16, 1, VaeWay::decode, 1.08},
                          {{5, 240, 416}, VaePrecision::bf16, 4, VaeWay::decode, 0.63},
                          {{9, 480, 832}, VaePrecision::bf16, 1, VaeWay::decode, 2.99},
                          {{5, 240, 416}, VaePrecision::f32, 1, VaeWay::encode, 1.32},
                          {{5, 240, 416}, VaePrecision::f32, 6, VaeWay::encode, 0.76},
                          {{5, 240, 416}, VaePrecision::bf16, 3, VaeWay::encode, 0.53}};
  for (const Measured& measured : all) {
    VaeOptions options;
    options.precision = measured.precision;
    options.bands = measured.bands;
    const double estimate = estimated_peak_bytes(VaeConfig{}, measured.size, options, measured.way) / 1e9;
    EXPECT_NEAR(estimate, measured.gigabytes, 0.2 * measured.gigabytes)
        << to_string(measured.precision) << "/" << measured.bands;
    EXPECT_GT(estimate, 0.95 * measured.gigabytes) << "--memory-limit would be exceeded";
  }
}

TEST(VaeCost, BandsTilesAndHalfNumbersNeedLessMemory) {
  const VaeConfig config;
  const ClipSize size{81, 480, 832};
  VaeOptions options;
  double before = estimated_peak_bytes(config, size, options, VaeWay::decode);
  EXPECT_GT(before, 4e9);
  for (const int bands : {2, 3, 4}) {
    options.bands = bands;
    const double now = estimated_peak_bytes(config, size, options, VaeWay::decode);
    EXPECT_LT(now, before);
    before = now;
  }
  options = {};
  options.precision = VaePrecision::bf16;
  EXPECT_LT(estimated_peak_bytes(config, size, options, VaeWay::decode), 4e9);
  options.tile = 256;
  EXPECT_LT(estimated_peak_bytes(config, size, options, VaeWay::decode), 2e9);
}

}  // namespace
}  // namespace uwv::model
