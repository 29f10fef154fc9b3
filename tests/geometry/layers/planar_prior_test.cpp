// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/planar_prior.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "uwv/eval/stock_scenes.h"

namespace uwv {
namespace {

constexpr double degree = std::numbers::pi / 180;

PlanarPriorResult prior_of(const std::vector<ImageRgb>& frames, const std::vector<ForegroundMask>& masks,
                           const PlanarPriorOptions& options = {}, double fov = 60 * degree) {
  ThreadPool pool(2);
  Monitor monitor;
  return planar_prior(frames, masks, Intrinsics::from_fov_x(fov, frames.front().size()), options, pool, monitor);
}

void expect_sane(const PlanarPriorResult& result, const std::string& what) {
  for (const FrameGeometry& frame : result.geometry.frames)
    for (std::size_t i = 0; i < frame.depth.pixels().size(); ++i) {
      const float z = frame.depth.data()[i], c = frame.confidence.data()[i];
      ASSERT_TRUE(std::isfinite(z) && z > 0) << what << ": depth " << z << " at " << i;
      ASSERT_TRUE(c > 0 && c <= 0.3F) << what << ": confidence " << c << " at " << i;
    }
  EXPECT_TRUE(std::isfinite(result.pitch) && result.backdrop_distance > 0) << what;
  EXPECT_FALSE(result.geometry.notes.empty());
}

ForegroundMask rectangle(Size size, int x0, int y0, int x1, int y1) {
  ForegroundMask mask(size);
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) mask(x, y) = 1;
  return mask;
}

// A plain floor and wall seen by an upright camera that looks down: with the rows given, the layout is the scene.
TEST(PlanarPrior, IsExactForGroundAndWall) {
  for (const double pitch : {-12 * degree, 0.0, 15 * degree}) {
    const Size size{160, 120};
    Camera camera{Intrinsics::from_fov_x(70 * degree, size), Rigid3{}, size};
    // Looking down turns the forward axis towards +y.
    camera.world_from_cam.rotation = Eigen::AngleAxisd(-pitch, Eigen::Vector3d::UnitX()).toRotationMatrix();
    Scene scene;
    SceneObject floor, wall;
    floor.world_from_object.rotation = Eigen::AngleAxisd(90 * degree, Eigen::Vector3d::UnitX()).toRotationMatrix();
    floor.world_from_object.translation = {0, 1.6, 0};
    wall.world_from_object.translation = {0, 0, 7};
    scene.objects = {floor, wall};
    ThreadPool pool(1);
    const SyntheticFrame truth = render(scene, camera, 0, pool);

    PlanarPriorOptions options;
    options.find_sky = false;
    options.horizon_row = camera.intrinsics.cy - camera.intrinsics.fy * std::tan(pitch);
    Eigen::Vector2d foot;
    ASSERT_TRUE(project(camera.intrinsics, camera.cam_from_world() * Eigen::Vector3d(0, 1.6, 7), foot));
    options.backdrop_row = foot.y();
    const PlanarPriorResult result = prior_of({truth.colour}, {}, options, 70 * degree);
    EXPECT_NEAR(result.pitch, pitch, 1e-9);
    EXPECT_NEAR(result.backdrop_distance, 7, 1e-6);
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; x += 40)
        ASSERT_NEAR(result.geometry.frames[0].depth(x, y), truth.depth(x, y), 1e-4 * truth.depth(x, y)) << y;
  }
}

TEST(PlanarPrior, StandsForegroundWhereItTouchesTheGround) {
  const Size size{320, 240};
  const std::vector<ImageRgb> frames{ImageRgb(size, Rgb8{80, 90, 60})};
  const std::vector<ForegroundMask> masks{rectangle(size, 140, 100, 180, 210)};
  PlanarPriorOptions options;
  options.horizon_row = 110;
  options.backdrop_row = 140;
  const auto flat = [&](double relief) {
    options.relief = relief;
    return prior_of(frames, masks, options).geometry.frames[0];
  };
  const FrameGeometry cardboard = flat(0), solid = flat(0.5);
  EXPECT_NEAR(cardboard.depth(160, 209), cardboard.depth(10, 209), 0.01 * cardboard.depth(10, 209)) << "foot on ground";
  EXPECT_NEAR(cardboard.depth(160, 110), cardboard.depth(160, 209), 0.05 * cardboard.depth(160, 209)) << "upright";
  EXPECT_LT(cardboard.depth(160, 120), 0.8F * cardboard.depth(10, 120)) << "before the backdrop";
  const double width = 40 * cardboard.depth(160, 150) / Intrinsics::from_fov_x(60 * degree, size).fx;
  const double bulge = cardboard.depth(160, 150) - solid.depth(160, 150);
  EXPECT_NEAR(bulge, 0.5 * 0.5 * width, 0.1 * width) << "half of half its width";
  EXPECT_LT(solid.depth(160, 150), solid.depth(141, 150)) << "round, not a step";
}

TEST(PlanarPrior, LockedOffBackdropDoesNotFlicker) {
  const Size size{128, 96};
  std::vector<ImageRgb> frames;
  std::vector<ForegroundMask> masks;
  for (int i = 0; i < 12; ++i) {
    frames.emplace_back(size, Rgb8{static_cast<std::uint8_t>(100 + i % 3), 100, 100});
    masks.push_back(rectangle(size, 20 + 4 * i, 40, 40 + 4 * i, 78 + (i % 2)));  // the foot trembles by a pixel
  }
  const PlanarPriorResult result = prior_of(frames, masks);
  for (int i = 1; i < 12; ++i) {
    const FrameGeometry &a = result.geometry.frames[static_cast<std::size_t>(i - 1)],
                        &b = result.geometry.frames[static_cast<std::size_t>(i)];
    for (int y = 0; y < size.height; ++y) ASSERT_EQ(a.depth(5, y), b.depth(5, y));
    const float at = a.depth(30 + 4 * (i - 1), 60), next = b.depth(30 + 4 * i, 60);
    // One row of the foot is 4 % of its distance here.
    EXPECT_NEAR(next / at, 1, 0.025) << "the body jumps with the foot in frame " << i;
  }
}

/// A floor 1.6 below the camera, of pale tiles with dark joints, up to a grey wall 12 away; the mean of 3x3 rays a
/// pixel.
ImageRgb tiled_floor(Size size, const Intrinsics& k, double pitch) {
  ImageRgb out(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      double sum = 0;
      for (int sub = 0; sub < 9; ++sub) {
        const double right = (x + (sub % 3 + 0.5) / 3 - k.cx) / k.fx, low = (y + (sub / 3 + 0.5) / 3 - k.cy) / k.fy;
        const double down = low * std::cos(pitch) + std::sin(pitch), forward = std::cos(pitch) - low * std::sin(pitch);
        const bool floor = down * 12 > 1.6 * forward;
        const double across = 1.6 * right / down + 100.2, along = 1.6 * forward / down;
        const bool joint = std::fmod(across, 0.7) < 0.05 || std::fmod(along, 0.7) < 0.05;
        sum += !floor ? 110 : joint ? 40 : 200;
      }
      const auto grey = static_cast<std::uint8_t>(sum / 9);
      out(x, y) = {grey, grey, grey};
    }
  return out;
}

TEST(PlanarPrior, FindsHorizonOfTiledFloor) {
  for (const double pitch : {-5 * degree, 0.0, 6 * degree}) {
    const Size size{416, 240};
    const Intrinsics k = Intrinsics::from_fov_x(60 * degree, size);
    const PlanarPriorResult result = prior_of({tiled_floor(size, k, pitch)}, {});
    EXPECT_EQ(result.horizon_from, LayoutCue::vanishing_lines);
    EXPECT_NEAR(result.horizon_row, k.cy - k.fy * std::tan(pitch), 4) << pitch / degree << " degrees";
  }
}

TEST(PlanarPrior, FindsSkyAndEndOfGround) {
  const Size size{320, 240};
  ImageRgb picture(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      picture(x, y) = y < 90    ? Rgb8{120, 170, 235}
                      : y < 150 ? Rgb8{static_cast<std::uint8_t>(60 + (x * 31 + y * 17) % 60), 60, 40}
                                : Rgb8{70, static_cast<std::uint8_t>(140 + (x * 7 + y * 5) % 9), 60};
  const PlanarPriorResult result = prior_of({picture}, {});
  EXPECT_EQ(result.horizon_from, LayoutCue::sky);
  EXPECT_NEAR(result.horizon_row, 90, 4);
  EXPECT_EQ(result.backdrop_from, LayoutCue::colour);
  EXPECT_NEAR(result.backdrop_row, 150, 4);
  EXPECT_NEAR(result.sky_share, 90.0 / 240, 0.02);
  const DepthMap& depth = result.geometry.frames[0].depth;
  EXPECT_GT(depth(100, 20), 3 * depth(100, 120));
  EXPECT_GT(depth(100, 155), depth(100, 235));
}

TEST(PlanarPrior, ScalesToMedianDepth) {
  PlanarPriorOptions options;
  options.median_depth = 1;
  const std::vector<ImageRgb> frames{ImageRgb({64, 48}, Rgb8{50, 60, 70})};
  const PlanarPriorResult one = prior_of(frames, {}, options), own = prior_of(frames, {});
  const auto ratio = own.geometry.frames[0].depth(3, 40) / one.geometry.frames[0].depth(3, 40);
  EXPECT_NEAR(own.backdrop_distance / one.backdrop_distance, ratio, 1e-4 * ratio);
  EXPECT_NEAR(own.camera_height / one.camera_height, ratio, 1e-4 * ratio);
  std::vector<float> sorted(one.geometry.frames[0].depth.pixels().begin(), one.geometry.frames[0].depth.pixels().end());
  std::sort(sorted.begin(), sorted.end());
  EXPECT_NEAR(sorted[(sorted.size() - 1) / 2], 1, 1e-6);
}

TEST(PlanarPrior, StaysSaneForAllMasksLensesAndSizes) {
  for (const Size size : {Size{1, 1}, Size{1, 40}, Size{40, 1}, Size{31, 57}, Size{96, 54}})
    for (const double fov : {1.0, 60.0, 170.0})
      for (int kind = 0; kind < 5; ++kind) {
        ForegroundMask mask(size, kind == 1 ? 1 : 0);
        if (kind == 2) mask(size.width / 2, size.height / 2) = 1;
        if (kind == 3)
          for (int x = 0; x < size.width; ++x) mask(x, 0) = mask(x, size.height - 1) = 1;
        if (kind == 4)
          for (std::size_t i = 0; i < mask.pixels().size(); i += 2) mask.data()[i] = 1;
        const std::vector<ForegroundMask> masks{mask};
        for (const double row : {-1e7, -5.0, 0.0, 0.5 * size.height, 1.0 * size.height, 1e7}) {
          PlanarPriorOptions options;
          options.horizon_row = row;
          expect_sane(prior_of({ImageRgb(size, Rgb8{90, 150, 240})}, masks, options, fov * degree),
                      fmt::format("{}x{} fov {} mask {} horizon {}", size.width, size.height, fov, kind, row));
        }
        expect_sane(prior_of({ImageRgb(size, Rgb8{90, 150, 240})}, masks, {}, fov * degree), "all sky");
      }
}

TEST(PlanarPrior, TakesLongClipsAndAppearingPieces) {
  const Size size{48, 32};
  std::vector<ImageRgb> frames(300, ImageRgb(size, Rgb8{20, 30, 40}));
  std::vector<ForegroundMask> masks;
  for (int i = 0; i < 300; ++i)
    masks.push_back(i % 50 < 10 ? ForegroundMask(size) : rectangle(size, i % 40, 10, i % 40 + 8, 30));
  const PlanarPriorResult result = prior_of(frames, masks);
  EXPECT_EQ(result.geometry.frames.size(), 300U);
  EXPECT_EQ(result.geometry.cameras.size(), 300U);
  expect_sane(result, "300 frames");
}

TEST(PlanarPrior, RefusesWhatDoesNotFit) {
  const std::vector<ImageRgb> frames(2, ImageRgb(8, 8));
  EXPECT_THROW(prior_of(frames, {ForegroundMask(8, 8)}), std::invalid_argument);
  EXPECT_THROW(prior_of(frames, {ForegroundMask(8, 8), ForegroundMask(8, 9)}), std::invalid_argument);
  PlanarPriorOptions options;
  options.farthest = 1;
  EXPECT_THROW(prior_of(frames, {}, options), std::invalid_argument);
}

}  // namespace
}  // namespace uwv
