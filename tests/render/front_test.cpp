// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/render_scenes.h"
#include "uwv/render/occlusion.h"

namespace uwv::testing {
namespace {

/// n . v by the definition, in double.
double facing(const PointGrid& points, const Camera& target, int x, int y) {
  const Camera& source = points.camera;
  const Eigen::Vector3d normal = normal_from_slope((*points.slopes)(x, y), x, y, source.intrinsics).cast<double>();
  const Eigen::Vector3d p = unproject(source.intrinsics, {x + 0.5, y + 0.5}, (*points.depth)(x, y));
  const Eigen::Vector3d centre = target_from_source(source, target).translation;
  return normal.dot((centre - p).normalized());
}

TEST(FrontTest, ComparesNormalAndViewAsDefined) {
  ThreadPool pool(2);
  for (const Scene& scene : all_scenes()) {
    if (scene.name == "extreme depths") continue;  // judged by the next test
    SCOPED_TRACE(scene.name);
    const PointGrid grid{scene.source, &scene.depth, &scene.slopes, nullptr};
    for (const double alpha_degrees : {20.0, 60.0, 90.0, 120.0}) {
      const double cos_alpha = std::cos(alpha_degrees * std::numbers::pi / 180);
      const ValidityMask front = front_mask(grid, scene.target, cos_alpha, pool);
      for (int y = 0; y < front.height(); ++y)
        for (int x = 0; x < front.width(); ++x) {
          if (!(scene.depth(x, y) > 0)) {
            ASSERT_EQ(front(x, y), 0);
            continue;
          }
          const double cosine = facing(grid, scene.target, x, y);
          if (std::abs(cosine - cos_alpha) < 1e-4) continue;
          ASSERT_EQ(front(x, y) != 0, cosine > cos_alpha) << x << ", " << y << " at alpha " << alpha_degrees;
        }
    }
  }
}

TEST(FrontTest, AlphaZeroKeepsNothingAndPiKeepsEverything) {
  ThreadPool pool(2);
  for (const Scene& scene : all_scenes()) {
    SCOPED_TRACE(scene.name);
    const PointGrid grid{scene.source, &scene.depth, &scene.slopes, nullptr};
    EXPECT_EQ(front_mask(grid, scene.target, 1.0, pool).count(), 0U);
    const std::size_t valid = static_cast<std::size_t>(
        std::count_if(scene.depth.pixels().begin(), scene.depth.pixels().end(), [](float z) { return z > 0; }));
    EXPECT_EQ(front_mask(grid, scene.target, -1.001, pool).count(), valid);
  }
}

TEST(FrontTest, APointFacingItsOwnCameraFacesIt) {
  ThreadPool pool(1);
  const Camera camera = test_camera({16, 9}, 1.2);
  const DepthMap depth(camera.size, 3.0F);
  EXPECT_EQ(front_mask({camera, &depth, nullptr, nullptr}, camera, 0.0, pool).count(), depth.size().pixels());
  // Seen from far behind the wall the same points show their backs.
  EXPECT_EQ(front_mask({camera, &depth, nullptr, nullptr}, test_camera({16, 9}, 1.2, {0, 0, 10}), 0.0, pool).count(),
            0U);
}

}  // namespace
}  // namespace uwv::testing
