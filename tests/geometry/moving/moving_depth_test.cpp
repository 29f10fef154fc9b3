// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "geometry/moving/orbiting_clip.h"
#include "uwv/core/depth.h"
#include "uwv/geometry/moving_objects.h"

namespace uwv::testing {
namespace {

/// 0 where the clip's object `mover` is.
std::vector<ValidityMask> exact_masks(const OrbitingClip& clip, int mover) {
  std::vector<ValidityMask> masks;
  for (const auto& object : clip.object) {
    ValidityMask& mask = masks.emplace_back(object.size(), std::uint8_t{1});
    for (std::size_t p = 0; p < mask.pixels().size(); ++p)
      if (object.pixels()[p] == mover) mask.pixels()[p] = 0;
  }
  return masks;
}

/// Mean relative error of the depth of masked pixels that belong to `mover`.
double mean_error(const std::vector<FrameGeometry>& got, const std::vector<ValidityMask>& masks,
                  const OrbitingClip& clip, int mover) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < got.size(); ++i)
    for (std::size_t p = 0; p < masks[i].pixels().size(); ++p)
      if (masks[i].pixels()[p] == 0 && clip.object[i].pixels()[p] == mover) {
        const double truth = clip.truth[i].depth.pixels()[p];
        sum += std::abs(got[i].depth.pixels()[p] - truth) / truth;
        count += 1;
      }
  return count > 0 ? sum / count : 0;
}

/// Without what MVS would not know: depth of the masked pixels.
std::vector<FrameGeometry> forget_moving(std::vector<FrameGeometry> geometry, const std::vector<ValidityMask>& masks) {
  for (std::size_t i = 0; i < geometry.size(); ++i)
    for (std::size_t p = 0; p < masks[i].pixels().size(); ++p)
      if (masks[i].pixels()[p] == 0) geometry[i].depth.pixels()[p] = 0, geometry[i].confidence.pixels()[p] = 0;
  return geometry;
}

class MovingDepthTest : public ::testing::Test {
 protected:
  OrbitingClip ball(double degrees, double unit, int frames = 7) {
    StockOptions stock;
    stock.size = {416, 240};
    stock.unit = unit;
    return orbiting_clip(moving_ball(stock), frames, degrees, 0.5, pool_);
  }
  MovingDepthSummary fill(const OrbitingClip& clip, const std::vector<ValidityMask>& masks,
                          std::vector<FrameGeometry>& geometry) {
    return fill_moving_depth(clip.frames, clip.cameras, masks, {}, pool_, monitor_, geometry);
  }
  ThreadPool pool_{2};
  Monitor monitor_;
};

TEST_F(MovingDepthTest, PutsTheBallWhereItTouchesTheFloorAtAnyScale) {
  for (const double unit : {1.0, 1e-6, 1e9}) {
    const OrbitingClip clip = ball(6, unit);
    const std::vector<ValidityMask> masks = exact_masks(clip, 0);
    std::vector<FrameGeometry> geometry = forget_moving(clip.truth, masks);
    const std::vector<FrameGeometry> before = geometry;
    const MovingDepthSummary summary = fill(clip, masks, geometry);
    EXPECT_LT(mean_error(geometry, masks, clip, 0), 0.08) << "unit " << unit;
    EXPECT_EQ(summary.objects.size(), 1U);
    EXPECT_EQ(summary.contact_share, 1.0);
    for (std::size_t i = 0; i < geometry.size(); ++i)
      for (std::size_t p = 0; p < masks[i].pixels().size(); ++p) {
        const bool moves = masks[i].pixels()[p] == 0;
        if (moves) {
          EXPECT_TRUE(is_valid_depth(geometry[i].depth.pixels()[p]));
          EXPECT_EQ(geometry[i].confidence.pixels()[p], 0.3F);
        } else {
          ASSERT_EQ(geometry[i].depth.pixels()[p], before[i].depth.pixels()[p]);
          ASSERT_EQ(geometry[i].confidence.pixels()[p], before[i].confidence.pixels()[p]);
        }
      }
  }
}

}  // namespace
}  // namespace uwv::testing
