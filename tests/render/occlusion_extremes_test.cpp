// SPDX-License-Identifier: Apache-2.0
// Algorithm 1 where numbers go wrong first: every kernel and visibility must stay finite, consistent and honest.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "uwv/eval/stock_scenes.h"
#include "uwv/render/occlusion.h"

namespace uwv::testing {
namespace {

constexpr double degree = std::numbers::pi / 180;

std::vector<OcclusionOptions> all_options() {
  std::vector<OcclusionOptions> all;
  for (const Kernel kernel : {Kernel::nearest, Kernel::bilinear, Kernel::resample})
    for (const Visibility visibility : {Visibility::none, Visibility::ztest, Visibility::reproject}) {
      OcclusionOptions options;
      options.kernel = kernel;
      options.visibility = visibility;
      options.reliability.enabled = false;
      all.push_back(options);
    }
  return all;
}

Camera camera_at(Size size, double fov, const Eigen::Vector3d& centre, double yaw = 0) {
  Camera camera;
  camera.size = size;
  camera.intrinsics = Intrinsics::from_fov_x(fov, size);
  camera.world_from_cam.rotation = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()).toRotationMatrix();
  camera.world_from_cam.translation = centre;
  return camera;
}

class OcclusionExtremes : public ::testing::Test {
 protected:
  /// Renders and checks what must hold for any input; returns the number of valid pixels.
  std::size_t render_soundly(const OcclusionOptions& options, const Camera& source, const DepthMap& depth,
                             const Camera& target) {
    SCOPED_TRACE(fmt::format("{} {}", to_string(options.kernel), to_string(options.visibility)));
    ImageRgb colour(depth.size());
    for (std::size_t i = 0; i < colour.size().pixels(); ++i)
      colour.data()[i] = {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i >> 8), 200};
    OcclusionRenderer renderer(*rasterizer_, pool_, options);
    SourceFrame frame;
    frame.camera = source;
    frame.colour = &colour;
    frame.depth = &depth;
    RenderedFrame out;
    renderer.render(frame, target, out);
    EXPECT_EQ(out.colour.size(), target.size);
    EXPECT_EQ(out.depth.size(), target.size);
    for (std::size_t i = 0; i < out.valid.size().pixels(); ++i) {
      const float z = out.depth.data()[i];
      if (!std::isfinite(z) || (out.valid.data()[i] != 0) != (z > 0)) {
        ADD_FAILURE() << "pixel " << i << " has depth " << z << " and valid " << int{out.valid.data()[i]};
        break;
      }
    }
    return out.valid.count();
  }

  ThreadPool pool_{2};
  std::unique_ptr<Rasterizer> rasterizer_ = make_cpu_rasterizer(pool_);
};

TEST_F(OcclusionExtremes, DepthsFromMicroscopicToAstronomic) {
  const Size size{64, 48};
  for (const float z : {1e-6F, 1.0F, 1e9F}) {
    const DepthMap depth(size, z);
    const Camera source = camera_at(size, 60 * degree, {0, 0, 0});
    // One pixel to the side at that depth, whatever the unit.
    const Camera target = camera_at(size, 60 * degree, {z / source.intrinsics.fx, 0, 0});
    for (const OcclusionOptions& options : all_options())
      EXPECT_NEAR(static_cast<double>(render_soundly(options, source, depth, target)), 63 * 48, 48) << "depth " << z;
  }
}

TEST_F(OcclusionExtremes, InvalidDepthsAreNotDrawn) {
  const Size size{32, 24};
  DepthMap depth(size);
  std::mt19937 random(1);
  const float values[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -3.0F, 0.0F};
  for (float& z : depth.pixels()) z = values[random() % 4];
  const Camera source = camera_at(size, 60 * degree, {0, 0, 0}), target = camera_at(size, 60 * degree, {0.1, 0, 0});
  for (const OcclusionOptions& options : all_options()) {
    DepthMap clean = depth;
    sanitize_depth(clean);
    EXPECT_EQ(render_soundly(options, source, clean, target), 0U);
    render_soundly(options, source, depth, target);  // also unsanitised: sound, if not useful
  }
}

TEST_F(OcclusionExtremes, HugeBaselineShowsNothingOrAPoint) {
  const Size size{64, 48};
  const DepthMap depth(size, 3.0F);
  for (const OcclusionOptions& options : all_options()) {
    EXPECT_EQ(render_soundly(options, camera_at(size, 1, {0, 0, 0}), depth, camera_at(size, 1, {1e6, 0, 0})), 0U);
    // From a million units behind, the whole wall is one pixel or straddles the corner of four.
    EXPECT_LE(render_soundly(options, camera_at(size, 1, {0, 0, 0}), depth, camera_at(size, 1, {0, 0, -1e6})), 9U);
  }
}

TEST_F(OcclusionExtremes, CameraInsideGeometryAndPointsOnItsPlane) {
  const Size size{64, 48};
  DepthMap depth(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) depth(x, y) = x % 2 == 0 ? 2.0F : 1.0F + 0.05F * static_cast<float>(x);
  for (const OcclusionOptions& options : all_options()) {
    // Exactly at depth 2: half of the points lie on the camera plane.
    render_soundly(options, camera_at(size, 1, {0, 0, 0}), depth, camera_at(size, 1, {0, 0, 2}));
    // Beyond everything, looking back.
    render_soundly(options, camera_at(size, 1, {0, 0, 0}), depth, camera_at(size, 1, {0.1, 0, 2}, std::numbers::pi));
  }
}

TEST_F(OcclusionExtremes, FieldsOfViewOfOneAndOf170Degrees) {
  for (const double fov : {1.0, 170.0})
    for (const OcclusionOptions& options : all_options()) {
      const Size size{80, 60};
      const DepthMap depth(size, 4.0F);
      const Camera source = camera_at(size, fov * degree, {0, 0, 0});
      const double one_pixel = 4.0 / source.intrinsics.fx;
      EXPECT_GT(render_soundly(options, source, depth, camera_at(size, fov * degree, {one_pixel, 0, 0})), 79U * 58U)
          << fov;
    }
}

TEST_F(OcclusionExtremes, TinyPictures) {
  for (const Size size : {Size{1, 1}, Size{3, 2}, Size{1, 40}})
    for (const OcclusionOptions& options : all_options()) {
      const DepthMap depth(size, 1.0F);
      render_soundly(options, camera_at(size, 1, {0, 0, 0}), depth, camera_at(size, 1, {0.01, 0, 0}));
      EXPECT_EQ(render_soundly(options, camera_at(size, 1, {0, 0, 0}), depth, camera_at(size, 1, {0, 0, 0})),
                size.pixels());
    }
}

TEST_F(OcclusionExtremes, TenMillionUnitsFromTheOriginAtCentimetreScale) {
  const auto render_at = [&](const Eigen::Vector3d& origin) {
    const StockScene scene = sphere_floor_wall({.size = {208, 120}, .origin = origin, .unit = 0.01});
    const SyntheticFrame frame = render(scene.scene, scene.source, 0, pool_);
    OcclusionRenderer renderer(*rasterizer_, pool_, {});
    SourceFrame source;
    source.camera = scene.source;
    source.colour = &frame.colour;
    source.depth = &frame.depth;
    RenderedFrame out;
    renderer.render(source, orbit_camera(scene.source, scene.subject_in_world, 15 * degree), out);
    return out;
  };
  const RenderedFrame here = render_at(Eigen::Vector3d::Zero()), far = render_at({1e7, -1e7, 1e7});
  std::size_t differ = 0;
  for (std::size_t i = 0; i < here.valid.size().pixels(); ++i) {
    const Rgb8 a = here.colour.data()[i], b = far.colour.data()[i];
    differ += here.valid.data()[i] != far.valid.data()[i] || std::abs(a.r - b.r) > 3 || std::abs(a.g - b.g) > 3;
  }
  // Doubles at 1e7 resolve 2e-9, a pixel here is about 1e-4 wide: a few borders may round differently.
  EXPECT_LE(differ, here.valid.size().pixels() / 200);
}

TEST_F(OcclusionExtremes, EightK) {
  const Size size{7680, 4320};
  const DepthMap depth(size, 2.0F);
  OcclusionOptions options;
  options.kernel = Kernel::nearest;
  EXPECT_GT(render_soundly(options, camera_at(size, 1, {0, 0, 0}), depth, camera_at(size, 1, {0.001, 0, 0})),
            size.pixels() * 98 / 100);
}

TEST_F(OcclusionExtremes, TwoThousandFramesOfOnePhoto) {
  const Size size{32, 24};
  const DepthMap depth(size, 2.0F);
  const ImageRgb colour(size, Rgb8{9, 8, 7});
  OcclusionRenderer renderer(*rasterizer_, pool_, {});
  SourceFrame source;
  source.camera = camera_at(size, 1, {0, 0, 0});
  source.colour = &colour;
  source.depth = &depth;
  RenderedFrame out;
  for (int k = 0; k < 2000; ++k) renderer.render(source, camera_at(size, 1, {0.1 * k / 2000, 0, 0}), out);
  EXPECT_GT(out.valid.count(), 22U * 24U * 9U / 10U);
}

TEST_F(OcclusionExtremes, AlphaZeroShowsNothingAndNinetyShowsTheFront) {
  const Size size{32, 24};
  const DepthMap depth(size, 2.0F);
  OcclusionOptions options;
  options.reliability.enabled = false;
  options.alpha = 0;
  EXPECT_EQ(render_soundly(options, camera_at(size, 1, {0, 0, 0}), depth, camera_at(size, 1, {0.01, 0, 0})), 0U);
  options.alpha = std::numbers::pi / 2;
  EXPECT_GT(render_soundly(options, camera_at(size, 1, {0, 0, 0}), depth, camera_at(size, 1, {0.01, 0, 0})), 700U);
}

}  // namespace
}  // namespace uwv::testing
