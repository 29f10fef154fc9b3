// SPDX-License-Identifier: Apache-2.0
#include "uwv/eval/visibility_truth.h"

#include <gtest/gtest.h>

#include <numbers>

#include "support/matchers.h"
#include "uwv/eval/stock_scenes.h"

namespace uwv {
namespace {

using Eigen::Vector3d;

constexpr double degree = std::numbers::pi / 180;

SceneObject placed(Shape shape, const Vector3d& position) {
  SceneObject object;
  object.shape = std::move(shape);
  object.world_from_object.translation = position;
  return object;
}

Camera camera_at(const Vector3d& position, Size size, double fov_x_degrees = 60) {
  Camera camera;
  camera.size = size;
  camera.intrinsics = Intrinsics::from_fov_x(fov_x_degrees * degree, size);
  camera.world_from_cam.translation = position;
  return camera;
}

// A second opinion that knows nothing of rays: it walks along segments in small steps and watches for the step at
// which it enters or leaves a solid, or passes to the other side of an infinite plane.
class Walker {
 public:
  Walker(const Scene& scene, double time) : scene_(scene) {
    for (const SceneObject& object : scene.objects)
      object_from_world_.push_back((object.motion ? object.motion(time) : object.world_from_object).inverse());
  }

  // Shares of the way at which a surface is met, leaving out the last bit before the end.
  std::vector<double> surfaces(const Vector3d& from, const Vector3d& to) const {
    std::vector<double> met;
    const int steps = 1200;
    for (std::size_t i = 0; i < scene_.objects.size(); ++i) {
      const auto side_at = [&](double t) { return inside(i, from + t * (to - from)); };
      for (int k = 0; k < steps; ++k) {
        double low = static_cast<double>(k) / steps;
        double high = static_cast<double>(k + 1) / steps;
        const bool before = side_at(low);
        if (side_at(high) == before) continue;
        for (int halving = 0; halving < 45; ++halving) {
          const double middle = 0.5 * (low + high);
          (side_at(middle) == before ? low : high) = middle;
        }
        if (high < 1 - 1e-6) met.push_back(high);
      }
    }
    return met;
  }

 private:
  bool inside(std::size_t i, const Vector3d& x_in_world) const {
    const Vector3d x = object_from_world_[i] * x_in_world;
    const Shape& shape = scene_.objects[i].shape;
    if (const auto* sphere = std::get_if<Sphere>(&shape)) return x.norm() < sphere->radius;
    if (const auto* box = std::get_if<Box>(&shape)) return (x.cwiseAbs() - box->half).maxCoeff() < 0;
    return x.z() > 0;
  }

  const Scene& scene_;
  std::vector<Rigid3> object_from_world_;
};

bool in_picture(const Camera& camera, const Vector3d& x_in_world) {
  const Vector3d x = camera.cam_from_world() * x_in_world;
  if (x.z() <= 0) return false;
  const double u = camera.intrinsics.fx * x.x() / x.z() + camera.intrinsics.cx;
  const double v = camera.intrinsics.fy * x.y() / x.z() + camera.intrinsics.cy;
  return u >= 0 && v >= 0 && u < camera.size.width && v < camera.size.height;
}

bool walked_visibility(const Walker& walker, const Camera& source, const Camera& target, const Vector3d& point) {
  const Vector3d s = source.world_from_cam.translation;
  const Vector3d t = target.world_from_cam.translation;
  if (!in_picture(target, point)) return false;
  for (const double share : walker.surfaces(t, point)) {
    const Vector3d surface = t + share * (point - t);
    if (in_picture(source, surface) && walker.surfaces(s, surface).empty()) return false;
  }
  return true;
}

TEST(VisibilityTruth, AgreesWithAWalkInSmallSteps) {
  ThreadPool pool(2);
  for (const auto& make : {sphere_floor_wall, boxes_room, moving_ball}) {
    const StockScene stock = make({.size = {20, 12}});
    for (const double angle : {-30 * degree, 60 * degree}) {
      const Camera target = orbit_camera(stock.source, stock.subject_in_world, angle);
      const double time = 0.45;
      const VisibilityTruth truth = visibility_truth(stock.scene, stock.source, target, time, pool);
      const Walker walker(stock.scene, time);
      int hidden = 0;
      for (int y = 0; y < 12; ++y) {
        for (int x = 0; x < 20; ++x) {
          const Vector3d direction = pixel_direction(stock.source, x + 0.5, y + 0.5);
          const Vector3d eye = stock.source.world_from_cam.translation;
          const Vector3d point = eye + stock.scene.trace(eye, direction, time).distance * direction;
          const bool expected = walked_visibility(walker, stock.source, target, point);
          hidden += expected ? 0 : 1;
          EXPECT_EQ(truth.visible(x, y) != 0, expected)
              << stock.name << " turned by " << angle / degree << " degrees, pixel (" << x << ", " << y << ")";
        }
      }
      EXPECT_GT(hidden, 12) << stock.name;
    }
  }
}

TEST(VisibilityTruth, FromItsOwnCameraEverythingIsVisible) {
  ThreadPool pool(2);
  for (const StockScene& stock : stock_scenes({.size = {208, 120}})) {
    const VisibilityTruth truth = visibility_truth(stock.scene, stock.source, stock.source, 0.2, pool);
    EXPECT_MASK_AGREES(truth.visible, ValidityMask(Size{208, 120}, 1), 1);
  }
}

TEST(VisibilityTruth, WhatTheSourceNeverSawHidesNothing) {
  ThreadPool pool(1);
  const Camera source = camera_at({0, 0, 0}, {81, 61});
  const Camera target = camera_at({1.5, 0, 0}, {81, 61}, 90);
  const SceneObject wall = placed(Plate{}, {0, 0, 10});
  const SceneObject front = placed(Plate{0.5, 0.5}, {0, 0, 2});
  const SceneObject shadowed = placed(Plate{0.9, 0.9}, {0, 0, 4});  // all behind `front` as the source sees it
  const SceneObject aside = placed(Plate{0.4, 0.4}, {3.4, 0, 5});   // outside the source's picture
  const SceneObject in_sight = placed(Plate{0.5, 0.5}, {-1.9, 0, 5});
  const auto truth_of = [&](std::vector<SceneObject> objects) {
    return visibility_truth({std::move(objects), Colour::Zero()}, source, target, 0, pool).visible;
  };
  const ValidityMask plain = truth_of({wall, front});
  EXPECT_LT(plain.count(), plain.pixels().size());
  EXPECT_MASK_AGREES(truth_of({wall, front, shadowed}), plain, 1);
  EXPECT_MASK_AGREES(truth_of({wall, front, aside}), plain, 1);
  EXPECT_LT(truth_of({wall, front, in_sight}).count(), plain.count());
  // Both do hide wall that the source sees, at x = -3 and x = 5.3.
  const Vector3d eye = target.world_from_cam.translation;
  const Scene scene{{wall, front, shadowed, aside}, Colour::Zero()};
  for (const double x : {-3.0, 5.3}) {
    EXPECT_EQ(scene.trace(source.world_from_cam.translation, {x, 0, 10}, 0).object, 0);
    EXPECT_EQ(scene.trace(eye, Vector3d(x, 0, 10) - eye, 0).object, x < 0 ? 2 : 3);
  }
}

TEST(VisibilityTruth, OutsideTheTargetsPictureIsNotVisible) {
  ThreadPool pool(1);
  const Scene wall{{placed(Plate{}, {0, 0, 4})}, Colour::Zero()};
  const Camera source = camera_at({0, 0, 0}, {80, 40}, 90);
  Camera narrow = source;
  narrow.intrinsics.fx *= 2;
  narrow.intrinsics.fy *= 2;
  const VisibilityTruth truth = visibility_truth(wall, source, narrow, 0, pool);
  EXPECT_EQ(truth.visible.count(), 40U * 20U);
  EXPECT_EQ(truth.visible(19, 20), 0);
  EXPECT_EQ(truth.visible(20, 20), 1);
  // One pixel on either side of the border of a 40x20 block: 42*22 - 38*18.
  EXPECT_EQ(truth.excluded.count(), 42U * 22U - 38U * 18U);
}

TEST(VisibilityTruth, SilhouettesAndEmptyPixelsAreExcluded) {
  ThreadPool pool(1);
  const Scene card{{placed(Plate{1, 1}, {0, 0, 4})}, Colour::Zero()};
  const Camera camera = camera_at({0, 0, 0}, {40, 40}, 90);
  const VisibilityTruth truth = visibility_truth(card, camera, camera, 0, pool);
  EXPECT_EQ(truth.visible.count(), 100U);
  EXPECT_EQ(truth.excluded.count(), 1600U - 64U);
}

TEST(VisibilityTruth, FarFromTheOriginItIsTheSame) {
  ThreadPool pool(2);
  const StockOptions here{.size = {208, 120}, .unit = 0.01};
  const StockOptions far{.size = {208, 120}, .origin = {-1e7, 1e7, 1e7}, .unit = 0.01};
  const std::vector<StockScene> near_scenes = stock_scenes(here);
  const std::vector<StockScene> far_scenes = stock_scenes(far);
  for (std::size_t i = 0; i < near_scenes.size(); ++i) {
    const auto truth_of = [&](const StockScene& stock) {
      const Camera target = orbit_camera(stock.source, stock.subject_in_world, 25 * degree);
      return visibility_truth(stock.scene, stock.source, target, 0, pool);
    };
    const PrecisionRecall score = compare(truth_of(far_scenes[i]).visible, truth_of(near_scenes[i]));
    EXPECT_GE(score.precision(), 0.9995) << near_scenes[i].name;
    EXPECT_GE(score.recall(), 0.9995) << near_scenes[i].name;
  }
}

TEST(VisibilityTruth, PicturesMayDifferInSizeAndHoldOnePixel) {
  ThreadPool pool(1);
  const StockScene stock = sphere_floor_wall({.size = {1, 1}});
  Camera target = orbit_camera(stock.source, stock.subject_in_world, 5 * degree);
  target.size = {64, 48};
  target.intrinsics = Intrinsics::from_fov_x(1, target.size);
  EXPECT_EQ(visibility_truth(stock.scene, stock.source, target, 0, pool).visible(0, 0), 1);
  target.size = {0, 0};
  EXPECT_THROW(visibility_truth(stock.scene, stock.source, target, 0, pool), std::invalid_argument);
}

TEST(VisibilityTruth, AccumulationKeepsWhatIsSurelyHiddenHidden) {
  // Columns: visible, hidden, and excluded with either value; rows: the same for the next frame.
  VisibilityTruth path{ValidityMask(4, 4), ExcludedMask(4, 4)};
  VisibilityTruth next{ValidityMask(4, 4), ExcludedMask(4, 4)};
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 4; ++x) {
      path.visible(x, y) = x % 2 == 0 ? 1 : 0;
      path.excluded(x, y) = x / 2 == 1 ? 1 : 0;
      next.visible(x, y) = y % 2 == 0 ? 1 : 0;
      next.excluded(x, y) = y / 2 == 1 ? 1 : 0;
    }
  }
  accumulate(path, next);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 4; ++x) {
      EXPECT_EQ(path.visible(x, y), x % 2 == 0 && y % 2 == 0 ? 1 : 0) << x << ", " << y;
      const bool surely_hidden = x == 1 || y == 1;
      EXPECT_EQ(path.excluded(x, y), !surely_hidden && (x / 2 == 1 || y / 2 == 1) ? 1 : 0) << x << ", " << y;
    }
  }
}

TEST(PrecisionRecall, CountsOnlyWhatIsNotExcluded) {
  ValidityMask mask(5, 1);
  ValidityMask truth(5, 1);
  ExcludedMask excluded(5, 1);
  const std::uint8_t mask_row[] = {1, 1, 0, 0, 1};
  const std::uint8_t truth_row[] = {1, 0, 1, 0, 0};
  for (int x = 0; x < 5; ++x) {
    mask(x, 0) = mask_row[x];
    truth(x, 0) = truth_row[x];
  }
  excluded(4, 0) = 1;
  const PrecisionRecall score = compare(mask, truth, excluded);
  EXPECT_EQ(score.tp, 1U);
  EXPECT_EQ(score.fp, 1U);
  EXPECT_EQ(score.fn, 1U);
  EXPECT_EQ(score.tn, 1U);
  EXPECT_EQ(score.precision(), 0.5);
  EXPECT_EQ(score.recall(), 0.5);
  EXPECT_EQ(score.f1(), 0.5);
  EXPECT_EQ(PrecisionRecall{}.precision(), 1);
  EXPECT_EQ(PrecisionRecall{}.recall(), 1);
  EXPECT_EQ((PrecisionRecall{.fp = 1, .fn = 1}).f1(), 0);
  EXPECT_THROW(compare(mask, truth, ExcludedMask(4, 1)), std::invalid_argument);
}

}  // namespace
}  // namespace uwv
