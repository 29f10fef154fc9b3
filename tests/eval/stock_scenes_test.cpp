// SPDX-License-Identifier: Apache-2.0
#include "uwv/eval/stock_scenes.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "support/matchers.h"

namespace uwv {
namespace {

using Eigen::Vector3d;

constexpr double degree = std::numbers::pi / 180;

TEST(StockScenes, EveryCameraLooksAtItsSubjectAndSeesSurfaceEverywhere) {
  ThreadPool pool(2);
  std::set<std::string> names;
  for (const StockScene& stock : stock_scenes({.size = {160, 96}})) {
    EXPECT_TRUE(names.insert(stock.name).second) << stock.name;
    Eigen::Vector2d pixel;
    ASSERT_TRUE(project(stock.source.intrinsics, stock.source.cam_from_world() * stock.subject_in_world, pixel));
    EXPECT_LT((pixel - Eigen::Vector2d(80, 48)).norm(), 1e-9) << stock.name;
    for (const double time : {0.0, stock.duration}) {
      const SyntheticFrame frame = render(stock.scene, stock.source, time, pool);
      for (const float depth : frame.depth.pixels()) ASSERT_GT(depth, 0.0F) << stock.name;
    }
  }
  EXPECT_EQ(names.size(), 7U);
}

TEST(StockScenes, TheBallIsAQuarterOfThePictureWide) {
  ThreadPool pool(2);
  const StockScene stock = sphere_floor_wall();
  const SyntheticFrame frame = render(stock.scene, stock.source, 0, pool);
  int widest = 0;
  for (int y = 0; y < frame.object.height(); ++y) {
    int width = 0;
    for (int x = 0; x < frame.object.width(); ++x) width += frame.object(x, y) == 0 ? 1 : 0;
    widest = std::max(widest, width);
  }
  EXPECT_NEAR(widest, 832 / 4, 1);
}

TEST(StockScenes, FenceBarsAreThreePixelsWide) {
  const StockScene stock = picket_fence();
  const SceneView view(stock.scene, stock.source.world_from_cam.translation, 0);
  int bars = 0;
  int pixels = 0;
  bool bar_before = false;
  for (int x = 0; x < 832; ++x) {
    const bool bar = view.first(pixel_direction(stock.source, x + 0.5, 240.5)).distance < 4;
    pixels += bar ? 1 : 0;
    bars += bar && !bar_before ? 1 : 0;
    bar_before = bar;
  }
  EXPECT_EQ(bars, 49);
  EXPECT_GE(pixels, 3 * 49);
  EXPECT_LT(pixels, 4 * 49) << "a bar aside of the middle also shows some of its flank";
}

TEST(StockScenes, OrbitKeepsDistanceAndSubject) {
  const StockScene stock = sphere_floor_wall();
  const Vector3d subject = stock.subject_in_world;
  const double radius = (stock.source.world_from_cam.translation - subject).norm();
  for (const double angle : {-70 * degree, 5 * degree, 90 * degree, 180 * degree}) {
    const Camera camera = orbit_camera(stock.source, subject, angle);
    EXPECT_NEAR((camera.world_from_cam.translation - subject).norm(), radius, 1e-12);
    const Vector3d in_camera = camera.cam_from_world() * subject;
    EXPECT_LT((in_camera - Vector3d(0, 0, radius)).norm(), 1e-12);
    EXPECT_RIGID_NEAR(orbit_camera(camera, subject, -angle).world_from_cam, stock.source.world_from_cam, 1e-12);
  }
  const Camera right = orbit_camera(stock.source, subject, 10 * degree);
  EXPECT_GT((stock.source.cam_from_world() * right.world_from_cam.translation).x(), 0);
  EXPECT_EQ(orbit_camera(stock.source, subject, 0), stock.source);
}

TEST(StockScenes, ApproachScalesTheDistanceAndKeepsTheDirection) {
  const StockScene stock = boxes_room({.origin = {5, 6, 7}});
  const Camera near = approach_camera(stock.source, stock.subject_in_world, 0.5);
  EXPECT_EQ(near.world_from_cam.rotation, stock.source.world_from_cam.rotation);
  EXPECT_NEAR((near.world_from_cam.translation - stock.subject_in_world).norm(), 1.5, 1e-12);
}

TEST(StockScenes, LookAtIsUprightAndRefusesTheVertical) {
  const Rigid3 pose = look_at({1, -2, 3}, {4, 5, 9});
  EXPECT_LT((pose.rotation.transpose() * pose.rotation - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_NEAR(pose.rotation.determinant(), 1, 1e-12);
  EXPECT_NEAR(pose.rotation(1, 0), 0, 1e-15) << "the x axis is level";
  EXPECT_GT(pose.rotation(1, 1), 0) << "y points down";
  EXPECT_THROW(look_at({0, 0, 0}, {0, 3, 0}), std::invalid_argument);
  EXPECT_THROW(look_at({1, 1, 1}, {1, 1, 1}), std::invalid_argument);
}

TEST(StockScenes, OptionsAreChecked) {
  EXPECT_THROW(corridor({.size = {0, 5}}), std::invalid_argument);
  EXPECT_THROW(corridor({.unit = 0}), std::invalid_argument);
}

}  // namespace
}  // namespace uwv
