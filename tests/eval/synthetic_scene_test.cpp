// SPDX-License-Identifier: Apache-2.0
#include "uwv/eval/synthetic_scene.h"

#include <gtest/gtest.h>

#include <numbers>

#include "support/matchers.h"
#include "uwv/eval/stock_scenes.h"

namespace uwv {
namespace {

using Eigen::Vector3d;

constexpr double degree = std::numbers::pi / 180;

Camera camera_with(double fov_x_degrees, Size size) {
  Camera camera;
  camera.size = size;
  camera.intrinsics = Intrinsics::from_fov_x(fov_x_degrees * degree, size);
  return camera;
}

SceneObject placed(Shape shape, const Vector3d& position,
                   const Eigen::Matrix3d& rotation = Eigen::Matrix3d::Identity()) {
  SceneObject object;
  object.shape = std::move(shape);
  object.world_from_object = {rotation, position};
  return object;
}

Eigen::Matrix3d turned(const Vector3d& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

TEST(SyntheticScene, PlaneDepthIsExact) {
  const Eigen::Matrix3d tilt = turned({1, 2, 0.5}, 0.7);
  const Vector3d on_plane(0.3, -0.2, 4);
  const Scene scene{{placed(Plate{}, on_plane, tilt)}, Colour::Zero()};
  Camera camera = camera_with(70, {64, 48});
  camera.world_from_cam = {turned({0, 1, 0.2}, 0.2), {0.5, -0.4, 0.3}};
  const Vector3d normal = tilt.col(2);
  const SceneView view(scene, camera.world_from_cam.translation, 0);
  for (int y = 0; y < camera.size.height; ++y) {
    for (int x = 0; x < camera.size.width; ++x) {
      const Vector3d direction = pixel_direction(camera, x + 0.5, y + 0.5);
      const double depth = normal.dot(on_plane - camera.world_from_cam.translation) / normal.dot(direction);
      const Hit hit = view.first(direction);
      ASSERT_EQ(static_cast<bool>(hit), depth > 0) << x << ", " << y;
      if (hit) {
        ASSERT_NEAR(hit.distance, depth, 1e-12 * depth) << x << ", " << y;
      }
    }
  }
}

// The picture of a ball at c is an ellipse of area pi f^2 r^2 sqrt(|c|^2 - r^2) / (c_z^2 - r^2)^(3/2).
TEST(SyntheticScene, BallCoversTheEllipseItShould) {
  ThreadPool pool(2);
  const Camera camera = camera_with(60, {832, 480});
  for (const Vector3d& centre : {Vector3d(0, 0, 3), Vector3d(0.7, -0.3, 2.5), Vector3d(-2, 0.5, 5)}) {
    const double radius = 0.4;
    const Scene scene{{placed(Sphere{radius}, centre)}, Colour::Zero()};
    const SyntheticFrame frame = render(scene, camera, 0, pool);
    double covered = 0;
    for (const std::int32_t object : frame.object.pixels()) covered += object == 0 ? 1 : 0;
    const double f = camera.intrinsics.fx;
    const double area = std::numbers::pi * f * f * radius * radius * std::sqrt(centre.squaredNorm() - radius * radius) /
                        std::pow(centre.z() * centre.z() - radius * radius, 1.5);
    EXPECT_NEAR(covered, area, 2e-3 * area) << "ball at " << centre.transpose();
  }
}

TEST(SyntheticScene, BallAndBoxAgreeWithTheirEquations) {
  const Eigen::Matrix3d rotation = turned({1, 1, 1}, 0.6);
  const Scene scene{{placed(Sphere{0.7}, {-1, 0, 4}), placed(Box{{0.5, 0.3, 0.4}}, {1, 0.2, 4}, rotation)},
                    Colour::Zero()};
  const Camera camera = camera_with(60, {80, 50});
  const SceneView view(scene, Vector3d::Zero(), 0);
  int seen[2] = {0, 0};
  for (int y = 0; y < camera.size.height; ++y) {
    for (int x = 0; x < camera.size.width; ++x) {
      const Vector3d direction = pixel_direction(camera, x + 0.5, y + 0.5);
      const Hit hit = view.first(direction);
      if (!hit) continue;
      ++seen[hit.object];
      const SceneObject& object = scene.objects[static_cast<std::size_t>(hit.object)];
      const Vector3d local = object.world_from_object.inverse() * (hit.distance * direction);
      if (hit.object == 0) {
        ASSERT_NEAR(local.norm(), 0.7, 1e-12);
        ASSERT_LT((hit.normal_in_world - local / 0.7).norm(), 1e-12);
      } else {
        const Vector3d relative = local.cwiseQuotient(Vector3d(0.5, 0.3, 0.4));
        ASSERT_NEAR(relative.cwiseAbs().maxCoeff(), 1, 1e-12);
        ASSERT_NEAR(relative.dot(rotation.transpose() * hit.normal_in_world), 1, 1e-9);
      }
      ASSERT_LT(hit.normal_in_world.dot(direction), 1e-9) << "outside, surfaces face the camera";
    }
  }
  EXPECT_GT(seen[0], 100);
  EXPECT_GT(seen[1], 100);
}

TEST(SyntheticScene, CrossingsComeInOrderAndAgreeWithBlocked) {
  const StockScene stock = boxes_room();
  const SceneView view(stock.scene, stock.source.world_from_cam.translation, 0);
  std::vector<Crossing> crossings;
  for (int y = 5; y < 480; y += 50) {
    for (int x = 5; x < 832; x += 50) {
      const Vector3d direction = pixel_direction(stock.source, x, y);
      view.crossings(direction, 100, crossings);
      ASSERT_FALSE(crossings.empty());
      ASSERT_TRUE(std::is_sorted(crossings.begin(), crossings.end(),
                                 [](const Crossing& a, const Crossing& b) { return a.distance < b.distance; }));
      const double nearest = crossings.front().distance;
      ASSERT_EQ(view.first(direction).distance, nearest);
      ASSERT_FALSE(view.blocked(direction, nearest));
      ASSERT_TRUE(view.blocked(direction, nearest * (1 + 1e-12)));
    }
  }
}

TEST(SyntheticScene, ASurfacePointHasOneColourFromEverywhere) {
  for (const StockScene& stock : stock_scenes()) {
    const Camera other = orbit_camera(stock.source, stock.subject_in_world, 30 * degree);
    const SceneView here(stock.scene, stock.source.world_from_cam.translation, 0.4);
    const SceneView there(stock.scene, other.world_from_cam.translation, 0.4);
    int met = 0;
    for (int y = 3; y < 480; y += 12) {
      for (int x = 3; x < 832; x += 12) {
        const Vector3d direction = pixel_direction(stock.source, x, y);
        const Hit hit = here.first(direction);
        if (!hit) continue;
        const Hit again = there.first(here.origin_in_world() - there.origin_in_world() + hit.distance * direction);
        if (again.object != hit.object || std::abs(again.distance - 1) > 1e-9) continue;
        ++met;
        ASSERT_LT((stock.scene.colour(hit) - stock.scene.colour(again)).cwiseAbs().maxCoeff(), 1e-4F) << stock.name;
      }
    }
    EXPECT_GT(met, 100) << stock.name;
  }
}

TEST(SyntheticScene, TheBallMovesAsToldAndTakesItsColoursAlong) {
  const StockScene stock = moving_ball();
  const SceneObject& ball = stock.scene.objects[0];
  const Vector3d travelled = ball.motion(1).translation - ball.motion(0).translation;
  EXPECT_LT((travelled - Vector3d(1.6, 0, 0)).norm(), 1e-12);
  const Vector3d mark = Vector3d(0.1, -0.2, -0.2).normalized() * std::get<Sphere>(ball.shape).radius;
  Colour colours[2];
  for (int i = 0; i < 2; ++i) {
    const double time = 0.05 * i;  // before the mark rolls out of sight
    const Vector3d mark_in_world = ball.motion(time) * mark;
    const Vector3d eye = stock.source.world_from_cam.translation;
    const Hit hit = stock.scene.trace(eye, mark_in_world - eye, time);
    ASSERT_EQ(hit.object, 0);
    ASSERT_NEAR(hit.distance, 1, 1e-9);
    colours[i] = stock.scene.colour(hit);
  }
  EXPECT_LT((colours[0] - colours[1]).norm(), 1e-5F);
}

TEST(SyntheticScene, FrameHoldsWhatTheRaysFound) {
  ThreadPool pool(2);
  const StockScene stock = sphere_floor_wall({.size = {104, 60}});
  const SyntheticFrame frame = render(stock.scene, stock.source, 0, pool);
  const Rigid3 cam_from_world = stock.source.cam_from_world();
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 104; ++x) {
      const Vector3d direction = pixel_direction(stock.source, x + 0.5, y + 0.5);
      const Hit hit = stock.scene.trace(stock.source.world_from_cam.translation, direction, 0);
      ASSERT_EQ(frame.object(x, y), hit.object);
      ASSERT_EQ(frame.depth(x, y), static_cast<float>(hit.distance));
      const Vector3d normal = frame.normals(x, y).cast<double>();
      ASSERT_NEAR(normal.norm(), 1, 1e-6);
      ASSERT_LT(normal.dot(cam_from_world.rotation * direction), 0) << "turned towards the camera";
    }
  }
}

TEST(SyntheticScene, ThreadsDoNotChangeThePicture) {
  ThreadPool one(1);
  ThreadPool four(4);
  const StockScene stock = boxes_room({.size = {120, 70}});
  const SyntheticFrame a = render(stock.scene, stock.source, 0, one);
  const SyntheticFrame b = render(stock.scene, stock.source, 0, four);
  EXPECT_IMAGE_NEAR(a.colour, b.colour, 0);
  EXPECT_EQ(a.depth, b.depth);
}

TEST(SyntheticScene, SupersamplingAveragesColourAndLeavesDepth) {
  ThreadPool pool(2);
  const StockScene stock = boxes_room({.size = {100, 60}});
  const SyntheticFrame one = render(stock.scene, stock.source, 0, pool);
  const SyntheticFrame nine = render(stock.scene, stock.source, 0, pool, 3);
  EXPECT_EQ(one.depth, nine.depth);
  EXPECT_NE(one.colour, nine.colour);
  // The middle one of nine rays is the single ray; the average of a smooth surface stays near it.
  std::size_t near = 0;
  for (std::size_t i = 0; i < one.colour.pixels().size(); ++i)
    near += std::abs(one.colour.pixels()[i].r - nine.colour.pixels()[i].r) <= 25 ? 1U : 0U;
  EXPECT_GT(near, one.colour.pixels().size() * 9 / 10);
  EXPECT_THROW(render(stock.scene, stock.source, 0, pool, 0), std::invalid_argument);
}

TEST(SyntheticScene, NothingHitIsInvalidAndShowsTheBackground) {
  ThreadPool pool(1);
  const Scene scene{{placed(Sphere{1}, {0, 0, -5})}, Colour(1, 0.5F, 0)};  // behind the camera
  const SyntheticFrame frame = render(scene, camera_with(60, {4, 3}), 0, pool);
  EXPECT_IMAGE_NEAR(frame.colour, ImageRgb({4, 3}, Rgb8{255, 128, 0}), 0);
  EXPECT_EQ(frame.depth, DepthMap({4, 3}, 0.0F));
  EXPECT_EQ(frame.object, Image<std::int32_t>({4, 3}, -1));
  EXPECT_EQ(frame.normals(1, 1), Eigen::Vector3f(0, 0, 0));
}

TEST(SyntheticScene, CameraInsideGeometrySeesItFromWithin) {
  ThreadPool pool(1);
  const Camera camera = camera_with(90, {33, 33});
  const Scene ball{{placed(Sphere{2}, {0, 0, 0})}, Colour::Zero()};
  const SyntheticFrame frame = render(ball, camera, 0, pool);
  EXPECT_FLOAT_EQ(frame.depth(16, 16), 2.0F);
  EXPECT_LT(frame.normals(16, 16).z(), 0) << "the inside faces the camera";
  const Scene box{{placed(Box{{1, 2, 3}}, {0, 0, 0})}, Colour::Zero()};
  EXPECT_FLOAT_EQ(render(box, camera, 0, pool).depth(16, 16), 3.0F);
}

TEST(SyntheticScene, ACameraOnASurfaceDoesNotSeeThatSurface) {
  const Scene scene{{placed(Plate{}, {0, 0, 0}), placed(Plate{}, {0, 0, 1})}, Colour::Zero()};
  const Hit hit = scene.trace(Vector3d::Zero(), {0.1, 0, 1}, 0);
  EXPECT_EQ(hit.object, 1);
}

TEST(SyntheticScene, NarrowAndWideLenses) {
  ThreadPool pool(2);
  const Scene wall{{placed(Plate{}, {0, 0, 5})}, Colour::Zero()};
  for (const double fov : {1.0, 170.0}) {
    const SyntheticFrame frame = render(wall, camera_with(fov, {64, 40}), 0, pool);
    EXPECT_DEPTH_NEAR(frame.depth, DepthMap({64, 40}, 5.0F), 1e-6);
  }
  EXPECT_EQ(render(wall, camera_with(60, {1, 1}), 0, pool).depth(0, 0), 5.0F);
}

TEST(SyntheticScene, CentimetresTenMillionUnitsAwayAreAsGoodAsHere) {
  ThreadPool pool(2);
  const StockOptions here{.size = {208, 120}, .unit = 0.01};
  const StockOptions far{.size = {208, 120}, .origin = {1e7, -1e7, 1e7}, .unit = 0.01};
  const std::vector<StockScene> near_scenes = stock_scenes(here);
  const std::vector<StockScene> far_scenes = stock_scenes(far);
  for (std::size_t i = 0; i < near_scenes.size(); ++i) {
    const SyntheticFrame a = render(near_scenes[i].scene, near_scenes[i].source, 0.3, pool);
    const SyntheticFrame b = render(far_scenes[i].scene, far_scenes[i].source, 0.3, pool);
    std::size_t same_object = 0;
    testing::Worst worst(1e-4);  // coordinates of 1e7 come in steps of 2e-9, a pixel here is 4e-5 wide
    for (int y = 0; y < 120; ++y) {
      for (int x = 0; x < 208; ++x) {
        if (a.object(x, y) != b.object(x, y)) continue;
        ++same_object;
        worst.see(x, y, std::abs(static_cast<double>(a.depth(x, y) / b.depth(x, y)) - 1));
      }
    }
    EXPECT_GT(same_object, 208U * 120U * 999U / 1000U) << near_scenes[i].name;
    EXPECT_EQ(worst.failed(), 0U) << near_scenes[i].name << ": worst depth at (" << worst.x() << ", " << worst.y()
                                  << "), off by " << worst.difference();
  }
}

}  // namespace
}  // namespace uwv
