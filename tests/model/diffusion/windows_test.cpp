// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/windows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace uwv::model {
namespace {

TEST(Windows, CoverEveryFrameWithWeightsThatSumToOneAndChangeSlowly) {
  for (const WindowOptions options :
       {WindowOptions{}, WindowOptions{9, 4}, WindowOptions{81, 4}, WindowOptions{21, 12}}) {
    for (std::int64_t latents = 1; latents < 150; ++latents) {
      const std::vector<Window> windows = plan_windows(latents, options);
      std::vector<double> sums(static_cast<std::size_t>(latents));
      for (const Window& window : windows) {
        EXPECT_LE(window.count, 1 + (options.frames - 1) / 4);
        ASSERT_GE(window.first, 0);
        ASSERT_LE(window.first + window.count, latents);
        for (std::size_t i = 0; i < window.weights.size(); ++i) {
          EXPECT_GT(window.weights[i], 0);
          sums[static_cast<std::size_t>(window.first) + i] += static_cast<double>(window.weights[i]);
        }
      }
      for (const double sum : sums) EXPECT_NEAR(sum, 1, 1e-5);
      for (std::size_t k = 1; k < windows.size(); ++k)
        EXPECT_GE(windows[k - 1].first + windows[k - 1].count - windows[k].first, options.overlap / 4);
    }
  }
}

TEST(Windows, AClipThatFitsIsOneWindow) {
  EXPECT_EQ(plan_windows(21, {}).size(), 1U);
  EXPECT_EQ(plan_windows(22, {}).size(), 2U);
  EXPECT_EQ(plan_windows(1, {}).size(), 1U);
}

TEST(Windows, OptionsThatDoNotFitLatentsAreRefused) {
  EXPECT_THROW(WindowOptions({80, 20}).check(), std::invalid_argument);
  EXPECT_THROW(WindowOptions({81, 0}).check(), std::invalid_argument);
  EXPECT_THROW(WindowOptions({81, 6}).check(), std::invalid_argument);
  EXPECT_THROW(WindowOptions({81, 80}).check(), std::invalid_argument);
  EXPECT_THROW(WindowOptions({1, 4}).check(), std::invalid_argument);
}

}  // namespace
}  // namespace uwv::model
