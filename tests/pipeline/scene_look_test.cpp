// SPDX-License-Identifier: Apache-2.0
#include "uwv/pipeline/scene_look.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace uwv {
namespace {

using ::testing::HasSubstr;

constexpr Size size = {96, 64};
ThreadPool pool(2);

/// Near square at depth 2 before a wall at 4.
DepthMap step_depth() {
  DepthMap depth(size, 4.0F);
  for (int y = 16; y < 48; ++y)
    for (int x = 32; x < 64; ++x) depth(x, y) = 2.0F;
  return depth;
}

struct Case {
  PathContext context;
  TargetPath path;
};

Case along(const std::string& preset) {
  const TrajectorySpec spec = trajectory_from_preset(preset);
  const Rigid3 still;
  Case made;
  made.context = make_context(spec, Intrinsics::from_fov_x(1.0, size), size, std::span(&still, 1), 1, 3.0, true);
  made.path = build_path(spec, made.context);
  return made;
}

/// Target cameras that stand elsewhere by the given amounts, all looking as the source does.
Case sideways(const std::vector<double>& offsets) {
  Case made = along("still");
  made.path.frames.resize(offsets.size(), made.path.frames.front());
  for (std::size_t i = 0; i < offsets.size(); ++i)
    made.path.frames[i].camera.world_from_cam.translation.x() += offsets[i];
  return made;
}

TEST(SceneLook, StandingStillHasNoParallax) {
  const Case still = sideways({0, 0, 0});
  const SceneLook look = look_at_scene(step_depth(), still.path, still.context, pool);
  EXPECT_FALSE(look.has_parallax);
  EXPECT_EQ(look.parallax_px, 0);
  EXPECT_EQ(look.first_return, -1);
  EXPECT_FLOAT_EQ(look.near_depth, 2);
  EXPECT_FLOAT_EQ(look.far_depth, 4);
  EXPECT_THAT(look.brief(), HasSubstr("no parallax"));
}

TEST(SceneLook, ParallaxOfASidewaysMoveIsDisparity) {
  const Case moved = sideways({0, 0.05, 0.1});
  const SceneLook look = look_at_scene(step_depth(), moved.path, moved.context, pool);
  // Depth 2 moves by fx * 0.1 / 2, depth 4 by half of that.
  const double expected = moved.context.intrinsics.fx * 0.1 * (1.0 / 2 - 1.0 / 4);
  EXPECT_TRUE(look.has_parallax);
  EXPECT_NEAR(look.parallax_px, expected, 1e-6);
  EXPECT_NEAR(look.disocclusion_px, expected, 1e-6);
  EXPECT_EQ(look.first_return, -1);
}

TEST(SceneLook, ComingBackIsNoticed) {
  const Case swing = sideways({0, 0.1, 0.2, 0.1, 0});
  EXPECT_EQ(look_at_scene(step_depth(), swing.path, swing.context, pool).first_return, 3);
}

TEST(SceneLook, NothingValidIsNoCrash) {
  const Case moved = sideways({0, 0.1});
  const SceneLook look = look_at_scene(DepthMap(size), moved.path, moved.context, pool);
  EXPECT_EQ(look.far_depth, 0);
  EXPECT_TRUE(look.has_parallax);
  EXPECT_EQ(look.parallax_px, 0);
}

TEST(SceneLook, PicturesOfOnePixel) {
  Case moved = sideways({0, 0.1});
  const SceneLook look = look_at_scene(DepthMap(1, 1, 2.0F), moved.path, moved.context, pool);
  EXPECT_FLOAT_EQ(look.near_depth, 2);
  EXPECT_EQ(look.disocclusion_px, 0);
}

TEST(SceneLook, EveryPresetGivesFiniteFigures) {
  for (const PresetInfo& preset : presets()) {
    const Case made = along(std::string(preset.name));
    const SceneLook look = look_at_scene(step_depth(), made.path, made.context, pool);
    EXPECT_TRUE(std::isfinite(look.parallax_px) && std::isfinite(look.disocclusion_px)) << preset.name;
    EXPECT_LT(look.parallax_px, 4 * size.width) << preset.name;
  }
}

}  // namespace
}  // namespace uwv
