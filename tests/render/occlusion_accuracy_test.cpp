// SPDX-License-Identifier: Apache-2.0
// Algorithm 1 against the analytic truth of a ball on a floor before a wall.
#include <gtest/gtest.h>

#include <array>
#include <numbers>

#include "uwv/eval/path_truth.h"
#include "uwv/eval/wrong_surface.h"
#include "uwv/render/occlusion.h"

namespace uwv::testing {
namespace {

class OcclusionAccuracy : public ::testing::Test {
 protected:
  OcclusionAccuracy() : scene_(sphere_floor_wall()), frame_(render(scene_.scene, scene_.source, 0, pool_)) {}

  PathTruth orbit(double degrees) {
    constexpr int steps = 6;
    return path_truth(scene_.scene, scene_.source, orbit_path(scene_, degrees * std::numbers::pi / 180, steps), 0,
                      pool_);
  }

  RenderedFrame follow(const std::vector<Camera>& cameras, const OcclusionOptions& options,
                       FrameMasks* masks = nullptr) {
    const auto rasterizer = make_cpu_rasterizer(pool_);
    OcclusionRenderer renderer(*rasterizer, pool_, options);
    RenderedFrame out;
    SourceFrame source;
    source.camera = scene_.source;
    source.colour = &frame_.colour;
    source.depth = &frame_.depth;
    for (const Camera& camera : cameras) renderer.render(source, camera, out, masks);
    return out;
  }

  WrongSurface wrong(const RenderedFrame& out, const Camera& target) {
    const std::array<Camera, 1> sources{scene_.source};
    return wrong_surface(scene_.scene, 0, target, sources, out.depth, out.valid, pool_);
  }

  ThreadPool pool_;
  StockScene scene_;
  SyntheticFrame frame_;
};

OcclusionOptions with(Visibility visibility) {
  OcclusionOptions options;
  options.visibility = visibility;
  options.reliability.enabled = false;  // the truth is about every pixel
  return options;
}

TEST_F(OcclusionAccuracy, MasksAgreeWithTheTruthUpToNinetyDegrees) {
  const std::array<std::pair<double, double>, 5> least{{{5, 0.99}, {20, 0.985}, {45, 0.96}, {70, 0.95}, {90, 0.95}}};
  for (const auto& [degrees, wanted] : least) {
    const PathTruth path = orbit(degrees);
    for (const Visibility visibility : {Visibility::reproject, Visibility::ztest}) {
      SCOPED_TRACE(fmt::format("{} at {} degrees", to_string(visibility), degrees));
      FrameMasks masks;
      follow(path.cameras, with(visibility), &masks);
      const PrecisionRecall second = compare(masks.second, path.last), visible = compare(masks.visible, path.product);
      EXPECT_GE(second.precision(), wanted);
      EXPECT_GE(second.recall(), wanted);
      EXPECT_GE(visible.precision(), wanted);
      EXPECT_GE(visible.recall(), wanted);
    }
  }
}

TEST_F(OcclusionAccuracy, FinalPictureShowsNoWrongSurface) {
  for (const double degrees : {5.0, 20.0, 45.0, 70.0, 90.0}) {
    SCOPED_TRACE(degrees);
    const PathTruth path = orbit(degrees);
    OcclusionOptions naive = with(Visibility::none);
    naive.normal_filter = false;
    const WrongSurface ours = wrong(follow(path.cameras, with(Visibility::reproject)), path.cameras.back());
    const WrongSurface theirs = wrong(follow(path.cameras, naive), path.cameras.back());
    EXPECT_LE(ours.wrong_share(), 0.001);
    RecordProperty(fmt::format("wrong_share_{}", degrees),
                   fmt::format("{} (naive {})", ours.wrong_share(), theirs.wrong_share()));
    // What the source never saw is in the way too; the product over the path removes most of that.
    EXPECT_LE(ours.through_unknown, theirs.through_unknown);
  }
}

TEST_F(OcclusionAccuracy, AProductOfManyFramesKeepsWhatIsVisible) {
  constexpr int steps = 81;
  const PathTruth path =
      path_truth(scene_.scene, scene_.source, orbit_path(scene_, std::numbers::pi / 2, steps), 0, pool_);
  for (const Visibility visibility : {Visibility::reproject, Visibility::ztest}) {
    SCOPED_TRACE(to_string(visibility));
    FrameMasks masks;
    follow(path.cameras, with(visibility), &masks);
    const PrecisionRecall visible = compare(masks.visible, path.product);
    EXPECT_GE(visible.precision(), 0.95);
    EXPECT_GE(visible.recall(), 0.95);
  }
}

TEST_F(OcclusionAccuracy, FilteredPointsStillHideWhatIsBehindThem) {
  for (const double degrees : {5.0, 20.0, 45.0}) {
    SCOPED_TRACE(degrees);
    const std::vector<Camera> camera = orbit_path(scene_, degrees * std::numbers::pi / 180, 1);
    OcclusionOptions options = with(Visibility::reproject);
    options.reliability.enabled = true;
    const WrongSurface hiding = wrong(follow(camera, options), camera.back());
    options.dropped_points_hide = false;
    const WrongSurface gone = wrong(follow(camera, options), camera.back());
    EXPECT_LE(hiding.wrong_share(), 0.001);
    EXPECT_LT(hiding.through_known + hiding.through_border, gone.through_known + gone.through_border);
  }
}

TEST_F(OcclusionAccuracy, SurfacesStayClosedWhenTheCameraComesTwiceAsClose) {
  std::vector<Camera> cameras;
  for (int k = 1; k <= 6; ++k)
    cameras.push_back(approach_camera(scene_.source, scene_.subject_in_world, 1.0 - 0.5 * k / 6));
  for (const Visibility visibility : {Visibility::reproject, Visibility::ztest, Visibility::none}) {
    const WrongSurface result = wrong(follow(cameras, with(visibility)), cameras.back());
    EXPECT_LE(result.hole_share(), 0.001) << to_string(visibility);
    EXPECT_LE(result.wrong_share(), 0.001) << to_string(visibility);
  }
}

}  // namespace
}  // namespace uwv::testing
