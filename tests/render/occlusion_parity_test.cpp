// SPDX-License-Identifier: Apache-2.0
// The official triple-reprojection branches, replayed with our primitives. The branches differ from the paper on
// purpose of compatibility only (geometry sheet, section 6), so they live in this test and not in the library.
#include <gtest/gtest.h>

#include "support/fixture_tensors.h"
#include "support/matchers.h"

namespace uwv::testing {
namespace {

class OcclusionParity : public ::testing::Test {
 protected:
  SoftSplat splat(const PointGrid& points, const ImageRgbF* colour, const Camera& target, float log_depth) {
    SoftSplat out;
    rasterizer_->soft_splat(points, colour, target, {50.0F, log_depth}, out);
    return out;
  }
  static SlopeMap slopes_of(const Golden& normals_world, std::size_t i, const Camera& camera) {
    auto normals = normals_world.interleaved<Eigen::Vector3f>(i);
    for (Eigen::Vector3f& n : normals.pixels()) n = camera.world_from_cam.rotation.transpose().cast<float>() * n;
    return slopes_from_normals(normals, camera.intrinsics);
  }
  static void expect_stable_equal(const ValidityMask& ours, const ValidityMask& golden, const ValidityMask& stable) {
    std::size_t flips = 0, agree = 0;
    for (std::size_t p = 0; p < golden.size().pixels(); ++p) {
      flips += stable.data()[p] != 0 && ours.data()[p] != golden.data()[p];
      agree += ours.data()[p] == golden.data()[p];
    }
    EXPECT_EQ(flips, 0U) << "stable pixels differ";
    EXPECT_GE(agree, golden.size().pixels() * 97 / 100);
  }

  ThreadPool pool_;
  std::unique_ptr<Rasterizer> rasterizer_ = make_cpu_rasterizer(pool_);
};

TEST_F(OcclusionParity, occlusion_single_view) {
  int frames = 0;
  for (const auto& path : fixture_files(fixture_folder("occlusion"), "single_view")) {
    SCOPED_TRACE(path.string());
    const SafeTensors file = SafeTensors::open(path.string());
    const auto depth = Golden(file, "in.depth").picture<DepthMap>();
    const auto colour = Golden(file, "in.colors").interleaved<RgbF>();
    const auto reliable = Golden(file, "in.reliable").picture<ValidityMask>();
    const Golden poses(file, "in.c2ws"), back_poses(file, "in.c2ws_reverse"), ks(file, "in.intrinsic");
    const Camera source =
        reference_camera(Golden(file, "in.K").matrix(), Golden(file, "in.c2w_0").matrix(), depth.size());
    const SlopeMap slopes = slopes_of(Golden(file, "in.normals_world"), 0, source);
    std::vector<Camera> targets;
    const PointGrid points{source, &depth, &slopes, &reliable};
    float log_depth = 0;
    for (std::size_t i = 0; i < poses.shape().at(0); ++i) {
      targets.push_back(reference_camera(ks.matrix(i), poses.matrix(i), depth.size()));
      log_depth = std::max(log_depth, log_depth_max(points, targets.back()));
    }
    ValidityMask visible(depth.size(), 1);
    for (std::size_t i = 0; i < targets.size(); ++i, ++frames) {
      SCOPED_TRACE("frame " + std::to_string(i));
      const SoftSplat first = splat(points, nullptr, targets[i], log_depth);
      // The reference's trick: unproject at the first camera, unzoomed, and look from the reverse trajectory.
      const PointGrid seen{source, &first.depth, nullptr, &first.valid};
      const Camera back = reference_camera(ks.matrix(i), back_poses.matrix(i), depth.size());
      intersect(visible, splat(seen, nullptr, back, 0).valid);
      ValidityMask kept = visible;
      intersect(kept, reliable);
      expect_stable_equal(kept, Golden(file, "cumulative_mask").picture<ValidityMask>(i),
                          Golden(file, "stable_cumulative").picture<ValidityMask>(i));
      intersect(kept, front_mask(points, targets[i], 0.0, pool_));
      const SoftSplat final = splat({source, &depth, &slopes, &kept}, &colour, targets[i], log_depth);
      expect_matches_golden(final, Golden(file, "render_masks").picture<ValidityMask>(i), Golden(file, "control_imgs"),
                            i, Golden(file, "stable_render").picture<ValidityMask>(i), nullptr);
    }
  }
  EXPECT_GT(frames, 0);
}

TEST_F(OcclusionParity, occlusion_dynamic_view) {
  int frames = 0;
  for (const auto& path : fixture_files(fixture_folder("occlusion"), "dynamic_view")) {
    SCOPED_TRACE(path.string());
    const SafeTensors file = SafeTensors::open(path.string());
    const Golden depths(file, "in.depths"), colours(file, "in.colors"), normals(file, "in.normals_world");
    const Golden fg(file, "in.fg"), reliable_all(file, "in.reliable"), k(file, "in.K"), ks(file, "in.intrinsic_target");
    const Golden source_poses(file, "in.c2ws_source"), target_poses(file, "in.c2ws_target");
    const std::size_t count = depths.shape().at(0);
    const Size size{static_cast<int>(depths.dimension(1)), static_cast<int>(depths.dimension(2))};
    std::vector<Camera> sources, targets;
    float log_depth = 0;
    for (std::size_t i = 0; i < count; ++i) {
      sources.push_back(reference_camera(k.matrix(), source_poses.matrix(i), size));
      targets.push_back(reference_camera(ks.matrix(i), target_poses.matrix(i), size));
      const auto depth = depths.picture<DepthMap>(i);
      log_depth = std::max(log_depth, log_depth_max({sources[i], &depth, nullptr, nullptr}, targets[i]));
    }
    ValidityMask visible;
    for (std::size_t i = 0; i < count; ++i, ++frames) {
      SCOPED_TRACE("frame " + std::to_string(i));
      const auto depth = depths.picture<DepthMap>(i);
      const auto foreground = fg.picture<ValidityMask>(i);
      const auto reliable = reliable_all.picture<ValidityMask>(i);
      const SlopeMap slopes = slopes_of(normals, i, sources[i]);
      const PointGrid points{sources[i], &depth, &slopes, &reliable};
      const ValidityMask front = front_mask(points, targets[i], 0.0, pool_);
      ValidityMask moving = foreground;
      intersect(moving, reliable);
      intersect(moving, front);
      const ValidityMask landed = splat({sources[i], &depth, nullptr, &moving}, nullptr, targets[i], log_depth).valid;
      const SoftSplat first = splat(points, nullptr, targets[i], log_depth);

      // Unprojected with frame 0's intrinsics, whatever the zoom.
      Camera unprojecting = targets[i];
      unprojecting.intrinsics = targets[0].intrinsics;
      const ValidityMask come_back = to_validity(GenerateMask(Image<std::uint8_t>(landed)));
      ValidityMask seen = splat({unprojecting, &first.depth, nullptr, &come_back}, nullptr, sources[i], 0).valid;
      // The reference does not mask holes: their depth 0 is a point at the target camera's centre, which the source may
      // see.
      Eigen::Vector2d pixel;
      const Eigen::Vector3d centre = target_from_source(sources[i], targets[i]).translation;
      if (project(sources[i].intrinsics, centre, pixel))
        for (const double dx : {-0.5, 0.5})
          for (const double dy : {-0.5, 0.5}) {
            const int x = static_cast<int>(std::floor(pixel.x() + dx)),
                      y = static_cast<int>(std::floor(pixel.y() + dy));
            if (seen.contains(x, y)) seen(x, y) = 1;
          }
      if (visible.empty())
        visible = seen;
      else
        intersect(visible, seen);
      for (std::size_t p = 0; p < size.pixels(); ++p) visible.data()[p] |= foreground.data()[p];
      ValidityMask kept = visible;
      intersect(kept, reliable);
      expect_stable_equal(kept, Golden(file, "cumulative_mask").picture<ValidityMask>(i),
                          Golden(file, "stable_cumulative").picture<ValidityMask>(i));
      intersect(kept, front);
      const auto colour = colours.interleaved<RgbF>(i);
      const SoftSplat final = splat({sources[i], &depth, nullptr, &kept}, &colour, targets[i], log_depth);
      expect_matches_golden(final, Golden(file, "render_masks").picture<ValidityMask>(i), Golden(file, "control_imgs"),
                            i, Golden(file, "stable_render").picture<ValidityMask>(i), nullptr);
    }
  }
  EXPECT_GT(frames, 0);
}

}  // namespace
}  // namespace uwv::testing
