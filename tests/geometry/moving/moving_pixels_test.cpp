// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "geometry/moving/orbiting_clip.h"
#include "uwv/geometry/moving_objects.h"

namespace uwv::testing {
namespace {

struct Agreement {
  double overlap = 0;       ///< Intersection over union with the truth, over all frames.
  double false_share = 0;   ///< Static pixels called moving, of all static pixels.
};

Agreement compare(const std::vector<ValidityMask>& masks, const OrbitingClip& clip, int mover) {
  double both = 0, either = 0, wrong = 0, still = 0;
  for (std::size_t i = 0; i < masks.size(); ++i)
    for (std::size_t p = 0; p < masks[i].pixels().size(); ++p) {
      const bool found = masks[i].pixels()[p] == 0, moves = clip.object[i].pixels()[p] == mover;
      both += found && moves;
      either += found || moves;
      wrong += found && !moves;
      still += !moves;
    }
  return {either > 0 ? both / either : 1.0, wrong / still};
}

class MovingPixelsTest : public ::testing::Test {
 protected:
  static OrbitingClip ball(double degrees, double unit, ThreadPool& pool, int frames = 9) {
    StockOptions stock;
    stock.size = {416, 240};
    stock.unit = unit;
    return orbiting_clip(moving_ball(stock), frames, degrees, 0.5, pool);
  }
  ThreadPool pool_{2};
  Monitor monitor_;
};

TEST_F(MovingPixelsTest, FindsTheBallWithAndWithoutDepth) {
  for (const double degrees : {-8.0, 8.0, 3.0, 0.0}) {
    const OrbitingClip clip = ball(degrees, 1, pool_);
    for (const bool with_depth : {false, true}) {
      const MovingPixels found = find_moving_pixels(
          clip.frames, clip.cameras, with_depth ? std::span<const FrameGeometry>(clip.truth) : std::span<const FrameGeometry>(), {}, pool_, monitor_);
      const Agreement got = compare(found.static_pixels, clip, 0);
      fmt::print("{} {}: overlap {:.3f} false {:.4f} | {}\n", degrees, with_depth, got.overlap, got.false_share, found.brief());
    }
  }
  StockOptions stock;
  stock.size = {416, 240};
  for (const auto& make : {boxes_room, corridor, slanted_planes, sphere_floor_wall, picket_fence, textured_plane}) {
    const StockScene scene = make(stock);
    const OrbitingClip clip = orbiting_clip(scene, 9, 8, 0, pool_);
    for (const bool with_depth : {false, true}) {
      const MovingPixels found = find_moving_pixels(
          clip.frames, clip.cameras, with_depth ? std::span<const FrameGeometry>(clip.truth) : std::span<const FrameGeometry>(), {}, pool_, monitor_);
      const Agreement got = compare(found.static_pixels, clip, -2);
      fmt::print("{} {}: false {:.4f} | {}\n", scene.name, with_depth, got.false_share, found.brief());
    }
  }
}

}  // namespace
}  // namespace uwv::testing
