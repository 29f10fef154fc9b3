// SPDX-License-Identifier: Apache-2.0
#include "model/vae/vae_tiles.h"

#include <gtest/gtest.h>

#include "model/layers/torch_scope.h"
#include "model/tensor_support.h"
#include "model/vae/wan_vae.h"
#include "support/matchers.h"

namespace uwv::model {
namespace {

using uwv::testing::fixture_folder;
using uwv::testing::near;

TEST(VaeTiles, TilesOfOnePictureMakeThatPicture) {
  const TorchScope scope(1);
  const at::Tensor picture = at::arange(2 * 1 * 22 * 34, at::TensorOptions(at::kFloat)).view({1, 2, 1, 22, 34});
  for (const std::int64_t stride : {3, 4, 5}) {
    const TileGrid grid{11, 17, 5, stride, 2};
    const at::Tensor whole = blended_tiles(grid, [&](Rows rows, Rows columns) {
      return picture.narrow(3, 2 * rows.begin, 2 * rows.count())
          .narrow(4, 2 * columns.begin, 2 * columns.count())
          .clone();
    });
    EXPECT_TRUE(near(whole, picture, 1e-3)) << stride;
  }
}

TEST(VaeTiles, TheLaterTileRisesInALine) {
  const TorchScope scope(1);
  // Two tiles of 8 columns, 4 apart: the first holds 0, the second 1.
  const TileGrid grid{1, 12, 8, 4, 1};
  const at::Tensor whole = blended_tiles(grid, [](Rows rows, Rows columns) {
    return at::full({1, 1, 1, rows.count(), columns.count()}, columns.begin == 0 ? 0.0 : 1.0);
  });
  const std::vector<float> expected{0, 0, 0, 0, 0, 0.25F, 0.5F, 0.75F, 1, 1, 1, 1};
  EXPECT_TRUE(near(whole.flatten(), at::tensor(expected), 1e-6));
}

TEST(VaeTiles, ATileTheSizeOfThePictureChangesNothingAndSmallerOnesLittle) {
  const TorchScope scope(1);
  Monitor monitor;
  const at::Tensor latents = at::linspace(-1, 1, 16 * 2 * 6 * 7).view({1, 16, 2, 6, 7});
  const auto decoded = [&](int tile) {
    VaeOptions options;
    options.tile = tile;
    return WanVae::open(fixture_folder("vae"), options).decode(latents, monitor);
  };
  const at::Tensor whole = decoded(0);
  EXPECT_TRUE(at::equal(decoded(64), whole));
  const at::Tensor tiled = decoded(32);
  EXPECT_EQ(tiled.sizes(), whole.sizes());
  EXPECT_FALSE(at::equal(tiled, whole));
  EXPECT_LT((tiled - whole).abs().mean().item<double>(), 0.2);
}

TEST(VaeTiles, TilesThatCannotBeAreRefused) {
  VaeOptions options;
  options.tile = 36;
  EXPECT_THROW(options.check(), std::invalid_argument);
  options.tile = 64;
  options.tile_stride = 72;
  EXPECT_THROW(options.check(), std::invalid_argument);
  options.tile_stride = 48;
  EXPECT_NO_THROW(options.check());
}

}  // namespace
}  // namespace uwv::model
