// SPDX-License-Identifier: Apache-2.0
#include "uwv/eval/wrong_surface.h"

#include <gtest/gtest.h>

#include <array>
#include <numbers>

#include "uwv/eval/stock_scenes.h"

namespace uwv {
namespace {

using Eigen::Vector3d;

constexpr double degree = std::numbers::pi / 180;
constexpr Size size{160, 96};

SceneObject placed(Shape shape, const Vector3d& position) {
  SceneObject object;
  object.shape = std::move(shape);
  object.world_from_object.translation = position;
  return object;
}

Camera camera_at(const Vector3d& position, double fov_x_degrees = 60) {
  Camera camera;
  camera.size = size;
  camera.intrinsics = Intrinsics::from_fov_x(fov_x_degrees * degree, size);
  camera.world_from_cam.translation = position;
  return camera;
}

class WrongSurfaceTest : public ::testing::Test {
 protected:
  WrongSurface judge(const Scene& scene, const Camera& source, const Camera& target, const DepthMap& depth,
                     const ValidityMask& valid) {
    const std::array sources{source};
    return wrong_surface(scene, 0, target, sources, depth, valid, pool_);
  }
  DepthMap depth_of(const Scene& scene, const Camera& camera) { return render(scene, camera, 0, pool_).depth; }

  ThreadPool pool_{2};
  ValidityMask all_{size, 1};
};

TEST_F(WrongSurfaceTest, TheTruthIsNeverWrongAndHasNoHoles) {
  for (const StockScene& stock : stock_scenes({.size = size})) {
    for (const double degrees : {-20.0, 0.0, 10.0, 45.0, 80.0}) {
      // Beyond these, plates are seen from behind and rightly counted: a test of its own below.
      if (stock.name == "slanted_planes" && degrees > 45) continue;
      if (stock.name == "corridor" && std::abs(degrees) > 15) continue;
      const Camera target = orbit_camera(stock.source, stock.subject_in_world, degrees * degree);
      const DepthMap depth = depth_of(stock.scene, target);
      const WrongSurface counts = judge(stock.scene, stock.source, target, depth, all_);
      const std::string where = stock.name + " turned by " + std::to_string(degrees);
      EXPECT_GT(counts.valid, size.pixels() / 2) << where;
      EXPECT_EQ(counts.through_known + counts.through_unknown + counts.through_border, 0U) << where;
      EXPECT_EQ(counts.back_faces, 0U) << where;
      EXPECT_EQ(counts.floating, 0U) << where;
      EXPECT_EQ(counts.holes, 0U) << where;
    }
  }
}

TEST_F(WrongSurfaceTest, BackgroundThroughTheBallIsCounted) {
  const StockScene stock = sphere_floor_wall({.size = size});
  Scene without_ball = stock.scene;
  without_ball.objects.erase(without_ball.objects.begin());
  const SyntheticFrame truth = render(stock.scene, stock.source, 0, pool_);
  std::size_t ball = 0;
  for (const std::int32_t object : truth.object.pixels()) ball += object == 0 ? 1U : 0U;
  const WrongSurface counts =
      judge(stock.scene, stock.source, stock.source, depth_of(without_ball, stock.source), all_);
  // All of the ball but its rim and the strip where it stands on the floor, where depths are about equal.
  EXPECT_GT(counts.through_known, ball * 8 / 10);
  EXPECT_LE(counts.through_known, ball);
  EXPECT_EQ(counts.through_unknown, 0U);
  EXPECT_NEAR(counts.wrong_share(), static_cast<double>(counts.through_known + counts.back_faces) / size.pixels(),
              1e-12);
}

TEST_F(WrongSurfaceTest, BackgroundThroughWhatTheSourceNeverSawIsCountedApart) {
  const SceneObject wall = placed(Plate{}, {0, 0, 10});
  const SceneObject front = placed(Plate{1, 1}, {0, 0, 2});
  const SceneObject shadowed = placed(Plate{1.5, 1.5}, {0, 0, 4});
  const Camera source = camera_at({0, 0, 0});
  const Camera target = camera_at({3, 0, 0}, 90);
  const Scene scene{{wall, front, shadowed}, Colour::Zero()};
  const WrongSurface counts = judge(scene, source, target, depth_of({{wall, front}, Colour::Zero()}, target), all_);
  EXPECT_GT(counts.through_unknown, 100U);
  EXPECT_EQ(counts.through_known, 0U);
  EXPECT_EQ(counts.back_faces, 0U);
  EXPECT_EQ(counts.wrong_share(), 0);
}

TEST_F(WrongSurfaceTest, BackFacesOfPlatesAndBallsAreCounted) {
  const StockScene view = textured_plane({.size = size});
  const Camera behind = orbit_camera(view.source, view.subject_in_world, 180 * degree);
  const Scene card{{placed(Plate{1, 0.5}, {0, 0, 0})}, Colour::Zero()};
  const DepthMap card_depth = depth_of(card, behind);
  const WrongSurface card_counts = judge(card, view.source, behind, card_depth, all_);
  EXPECT_GT(card_counts.back_faces, card_counts.valid * 8 / 10);
  EXPECT_EQ(card_counts.known, 0U);

  // Seen from behind, a ball whose source-side points shine through is deeper than it should be.
  const Scene ball{{placed(Sphere{0.5}, {0, 0, 0})}, Colour::Zero()};
  DepthMap far_side(size, 0.0F);
  const SceneView rays(ball, behind.world_from_cam.translation, 0);
  std::vector<Crossing> crossings;
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      rays.crossings(pixel_direction(behind, x + 0.5, y + 0.5), 100, crossings);
      if (crossings.size() == 2) far_side(x, y) = static_cast<float>(crossings[1].distance);
    }
  }
  const WrongSurface ball_counts = judge(ball, view.source, behind, far_side, all_);
  EXPECT_GT(ball_counts.back_faces, ball_counts.valid * 8 / 10);
  EXPECT_EQ(ball_counts.through_known, 0U);
  EXPECT_GT(ball_counts.wrong_share(), 0.8);
}

TEST_F(WrongSurfaceTest, WhatHangsInTheAirIsFloating) {
  const StockScene stock = textured_plane({.size = size});
  const WrongSurface counts = judge(stock.scene, stock.source, stock.source, DepthMap(size, 2.0F), all_);
  EXPECT_EQ(counts.floating, size.pixels());
  EXPECT_EQ(counts.wrong_share(), 0);
}

TEST_F(WrongSurfaceTest, HolesCountOnlyWhereTheSourceKnows) {
  const StockScene stock = sphere_floor_wall({.size = size});
  const Camera target = orbit_camera(stock.source, stock.subject_in_world, 45 * degree);
  const DepthMap depth = depth_of(stock.scene, target);
  const WrongSurface empty = judge(stock.scene, stock.source, target, depth, ValidityMask(size, 0));
  EXPECT_EQ(empty.valid, 0U);
  EXPECT_GT(empty.known, 1000U);
  EXPECT_LT(empty.known, size.pixels());
  EXPECT_EQ(empty.holes, empty.known);
  EXPECT_EQ(empty.hole_share(), 1);

  ValidityMask one_hole = all_;
  one_hole(size.width / 2, size.height / 2) = 0;  // the ball's middle
  EXPECT_EQ(judge(stock.scene, stock.source, target, depth, one_hole).holes, 1U);
  // Where depth is invalid, a mask that says valid does not help.
  DepthMap torn = depth;
  torn(size.width / 2, size.height / 2) = 0;
  EXPECT_EQ(judge(stock.scene, stock.source, target, torn, all_).holes, 1U);
}

TEST_F(WrongSurfaceTest, ASecondSourceKnowsMore) {
  const StockScene stock = sphere_floor_wall({.size = size});
  const Camera target = orbit_camera(stock.source, stock.subject_in_world, 45 * degree);
  const std::array both{stock.source, target};
  const DepthMap depth = depth_of(stock.scene, target);
  const WrongSurface counts = wrong_surface(stock.scene, 0, target, both, depth, ValidityMask(size, 0), pool_);
  const WrongSurface single = judge(stock.scene, stock.source, target, depth, ValidityMask(size, 0));
  EXPECT_GT(counts.known, single.known);
  EXPECT_GT(counts.known, size.pixels() * 9 / 10);
}

TEST_F(WrongSurfaceTest, MistakesOfTheCallerAreRefused) {
  const StockScene stock = textured_plane({.size = size});
  const DepthMap depth(size, 3.0F);
  EXPECT_THROW(wrong_surface(stock.scene, 0, stock.source, {}, depth, all_, pool_), std::invalid_argument);
  EXPECT_THROW(judge(stock.scene, stock.source, stock.source, DepthMap(3, 3), all_), std::invalid_argument);
  EXPECT_THROW((WrongSurfaceOptions{.depth_tolerance = 0}).check(), std::invalid_argument);
  EXPECT_THROW((WrongSurfaceOptions{.grazing = 1}).check(), std::invalid_argument);
}

}  // namespace
}  // namespace uwv
