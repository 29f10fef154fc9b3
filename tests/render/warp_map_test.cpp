// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>

#include "support/render_scenes.h"

namespace uwv::testing {
namespace {

Eigen::Vector3d warped(const WarpMap& map, int x, int y, float z) {
  Eigen::Vector3d p;
  for (std::size_t i = 0; i < 3; ++i)
    p[static_cast<Eigen::Index>(i)] =
        z * (map.a[i][0] * static_cast<float>(x) + (map.a[i][1] * static_cast<float>(y) + map.a[i][2])) + map.b[i];
  return {p.x() / p.z(), p.y() / p.z(), p.z()};
}

TEST(WarpMapTest, AgreesWithProjectingThroughTheWorld) {
  const Camera source = test_camera({640, 480}, 1.1, {1, 2, 3}, 0.4, -0.2);
  const Camera target = test_camera({320, 200}, 0.7, {1.5, 1.8, 2.5}, 0.3, 0.1);
  const WarpMap map = WarpMap::between(source, target);
  for (const auto& [x, y, z] : {std::tuple{0, 0, 2.0F}, {639, 479, 3.0F}, {100, 400, 10.0F}}) {
    const Eigen::Vector3d in_world = source.world_from_cam * unproject(source.intrinsics, {x + 0.5, y + 0.5}, z);
    const Eigen::Vector3d in_target = target.cam_from_world() * in_world;
    Eigen::Vector2d pixel;
    ASSERT_TRUE(project(target.intrinsics, in_target, pixel));
    const Eigen::Vector3d ours = warped(map, x, y, z);
    EXPECT_NEAR(ours.x(), pixel.x(), 1e-3);
    EXPECT_NEAR(ours.y(), pixel.y(), 1e-3);
    EXPECT_NEAR(ours.z(), in_target.z(), 1e-5 * z);
  }
}

TEST(WarpMapTest, TheWayBackUndoesTheWayThere) {
  const Camera source = test_camera({640, 480}, 1.1, {1, 2, 3}, 0.4, -0.2);
  const Camera target = test_camera({320, 200}, 0.7, {1.5, 1.8, 2.5}, 0.3, 0.1);
  const WarpMap map = WarpMap::between(source, target);
  const Eigen::Vector3d there = warped(map, 100, 400, 10.0F);
  Eigen::Vector3d s;
  for (std::size_t i = 0; i < 3; ++i)
    s[static_cast<Eigen::Index>(i)] =
        (map.a_inverse[i][0] * there.x() + map.a_inverse[i][1] * there.y() + map.a_inverse[i][2]) * there.z() -
        map.k[i];
  EXPECT_NEAR(s.x() / s.z(), 100.5, 2e-3);
  EXPECT_NEAR(s.y() / s.z(), 400.5, 2e-3);
  EXPECT_NEAR(s.z(), 10, 1e-4);
}

TEST(WarpMapTest, SameCameraIsExactlyTheIdentity) {
  const Camera camera = test_camera({640, 480}, 1.1, {1e7, 2e6, -3e7}, 0.4, -0.2);
  const WarpMap map = WarpMap::between(camera, camera);
  EXPECT_TRUE(map.identity);
  EXPECT_TRUE(map.no_translation);
  for (const int x : {0, 1, 639}) EXPECT_EQ(warped(map, x, 7, 2.0F), Eigen::Vector3d(x + 0.5, 7.5, 2));
}

TEST(WarpMapTest, TurningOrZoomingHasNoTranslation) {
  const Camera camera = test_camera({64, 48}, 1.1, {5, 6, 7});
  Camera turned = test_camera({64, 48}, 1.1, {5, 6, 7}, 0.2);
  EXPECT_TRUE(WarpMap::between(camera, turned).no_translation);
  EXPECT_FALSE(WarpMap::between(camera, turned).identity);
  turned.world_from_cam.translation.x() += 1e-9;
  EXPECT_FALSE(WarpMap::between(camera, turned).no_translation);
}

TEST(WarpMapTest, CentimetresSurviveTenMillionUnitsFromTheOrigin) {
  const Eigen::Vector3d far(1e7, -1e7, 1e7);
  const Camera source = test_camera({640, 480}, 1.1, far, 0.4, -0.2);
  const Camera target = test_camera({640, 480}, 1.1, far + Eigen::Vector3d(0.02, 0.01, -0.01), 0.35, -0.2);
  const Camera near_source = test_camera({640, 480}, 1.1, {0, 0, 0}, 0.4, -0.2);
  const Camera near_target = test_camera({640, 480}, 1.1, {0.02, 0.01, -0.01}, 0.35, -0.2);
  const WarpMap a = WarpMap::between(source, target), b = WarpMap::between(near_source, near_target);
  for (const float z : {0.05F, 0.5F})
    EXPECT_LT((warped(a, 300, 200, z) - warped(b, 300, 200, z)).norm(), 1e-3) << "depth " << z;
}

}  // namespace
}  // namespace uwv::testing
