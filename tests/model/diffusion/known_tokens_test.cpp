// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/known_tokens.h"

#include <ATen/ATen.h>
#include <ATen/CPUGeneratorImpl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

namespace uwv::model {
namespace {

/// By the definition: every token against every unknown one.
at::Tensor near_by_search(const at::Tensor& unknown, std::int64_t margin) {
  at::Tensor near = at::zeros_like(unknown);
  const at::Tensor places = unknown.nonzero(), all = at::ones_like(unknown).nonzero();
  for (std::int64_t i = 0; i < all.size(0); ++i)
    if (places.size(0) > 0 && std::get<0>((places - all[i]).abs().max(1)).min().item<std::int64_t>() <= margin)
      near[all[i][0].item<std::int64_t>()][all[i][1].item<std::int64_t>()][all[i][2].item<std::int64_t>()] = true;
  return near;
}

TEST(KnownTokens, AMarginIsCountedAlongEveryAxis) {
  const at::Generator generator = at::detail::createCPUGenerator(3);
  for (const double share : {0.0, 0.02, 0.1, 1.0})
    for (const std::int64_t margin : {0, 1, 2, 9, 1000}) {
      const at::Tensor unknown = at::rand({4, 5, 7}, generator, at::TensorOptions(at::kFloat)).lt(share);
      EXPECT_TRUE(at::equal(near_unknown(unknown, margin), near_by_search(unknown, margin))) << share << " " << margin;
    }
}

TEST(KnownTokens, PlacesRiseAndLatentsFollowTheirToken) {
  at::Tensor tokens = at::zeros({2, 2, 3}, at::kBool);
  tokens[0][1][2] = true;
  tokens[1][0][0] = true;
  EXPECT_TRUE(at::equal(places_of(tokens), at::tensor({5, 6}, at::kLong)));
  const at::Tensor latents = latents_of_tokens(tokens);
  EXPECT_EQ(latents.sizes().vec(), (std::vector<std::int64_t>{1, 1, 2, 4, 6}));
  EXPECT_EQ(latents.sum().item<std::int64_t>(), 8);
  EXPECT_TRUE(latents[0][0][0].slice(0, 2).slice(1, 4).all().item<bool>());
  EXPECT_TRUE(latents[0][0][1].slice(0, 0, 2).slice(1, 0, 2).all().item<bool>());
}

TEST(KnownTokens, ANegativeMarginIsRefused) {
  EXPECT_THROW(near_unknown(at::zeros({1, 1, 1}, at::kBool), -1), std::invalid_argument);
  EXPECT_THROW(near_unknown(at::zeros({1, 1}, at::kBool), 1), std::invalid_argument);
}

}  // namespace
}  // namespace uwv::model
