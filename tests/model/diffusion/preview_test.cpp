// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/preview.h"

#include "model/diffusion/noise.h"
#include "model/tensor_support.h"

namespace uwv::model {
namespace {

TEST(LatentColours, ColoursThatFollowFromLatentsAreFoundAgain) {
  const at::Tensor latents = seeded_noise({1, 16, 5, 6, 8}, 3);
  const at::Tensor colours = at::stack({0.3 * latents[0][2] - 0.1 * latents[0][7], 0.2 * latents[0][0] + 0.1,
                                        0.1 * latents[0][15] - 0.2 * latents[0][4]});
  const ImageRgb picture = LatentColours(latents, colours).picture(latents, 3, 2);
  ASSERT_EQ(picture.size(), (Size{16, 12}));
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 16; ++x) {
      const double green = 127.5 * colours[1][3][y / 2][x / 2].item<double>() + 127.5;
      EXPECT_NEAR(picture(x, y).g, std::clamp(green, 0.0, 255.0), 2);
    }
}

TEST(LatentColours, AClipOfOneColourGivesAPicture) {
  const at::Tensor latents = at::ones({1, 16, 1, 1, 1});
  const ImageRgb picture = LatentColours(latents, at::full({3, 1, 1, 1}, 0.5)).picture(latents, 0, 1);
  EXPECT_NEAR(picture(0, 0).r, 191, 1);
}

}  // namespace
}  // namespace uwv::model
