// SPDX-License-Identifier: Apache-2.0
// The official triple-reprojection branches, replayed with our primitives. The branches differ from the paper (geometry
// sheet, section 6), so they live in this test and not in the library.
#include <gtest/gtest.h>

#include "support/fixture_tensors.h"
#include "support/matchers.h"
#include "support/rounding_bounds.h"

namespace uwv::testing {
namespace {

class OcclusionParity : public ::testing::Test {
 protected:
  SoftSplat splat(const PointGrid& points, const ImageRgbF* colour, const Camera& target, float log_depth) {
    SoftSplat out;
    rasterizer_->soft_splat(points, colour, target, {50.0F, log_depth}, out);
    return out;
  }

  Bounds landing(const PointGrid& points, const Bounds& keep, const Camera& target) {
    return landing_bounds(*rasterizer_, points, keep, target);
  }

  /// Final colours where noise in the masks before makes no difference.
  void compare_final(const PointGrid& points, const Bounds& kept, const ImageRgbF& colour, const Camera& target,
                     float log_depth, const SafeTensors& file, std::size_t i, BoundsTally& tally) {
    PointGrid grid = points;
    grid.keep = &kept.least;
    const SoftSplat least = splat(grid, &colour, target, log_depth);
    grid.keep = &kept.most;
    const SoftSplat most = splat(grid, &colour, target, log_depth);
    const Bounds landed = landing(points, kept, target);
    const auto stable = Golden(file, "stable_render").picture<ValidityMask>(i);
    const auto golden = Golden(file, "render_masks").picture<ValidityMask>(i);
    tally.add(landed, golden, stable);
    ValidityMask comparable = stable;
    for (std::size_t p = 0; p < stable.size().pixels(); ++p) {
      const RgbF &a = least.colour.data()[p], &b = most.colour.data()[p];
      comparable.data()[p] &= landed.least.data()[p] == landed.most.data()[p] &&
                              std::max({std::fabs(a.r - b.r), std::fabs(a.g - b.g), std::fabs(a.b - b.b)}) < 1e-4F;
    }
    expect_matches_golden(least, golden, Golden(file, "control_imgs"), i, comparable, nullptr);
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
    const auto normals = Golden(file, "in.normals_world").interleaved<Eigen::Vector3f>();
    const Golden poses(file, "in.c2ws"), back_poses(file, "in.c2ws_reverse"), ks(file, "in.intrinsic");
    const Camera source =
        reference_camera(Golden(file, "in.K").matrix(), Golden(file, "in.c2w_0").matrix(), depth.size());
    const PointGrid points{source, &depth, nullptr, &reliable};
    std::vector<Camera> targets;
    float log_depth = 0;
    for (std::size_t i = 0; i < poses.shape().at(0); ++i) {
      targets.push_back(reference_camera(ks.matrix(i), poses.matrix(i), depth.size()));
      log_depth = std::max(log_depth, log_depth_max(points, targets.back()));
    }
    const ValidityMask all(depth.size(), 1);
    Bounds visible{all, all};
    BoundsTally kept_tally, final_tally;
    for (std::size_t i = 0; i < targets.size(); ++i, ++frames) {
      SCOPED_TRACE("frame " + std::to_string(i));
      const SoftSplat first = splat(points, nullptr, targets[i], log_depth);
      // The reference's trick: unproject at the first camera, unzoomed, and look from the reverse trajectory.
      const PointGrid seen{source, &first.depth, nullptr, nullptr};
      const Camera back = reference_camera(ks.matrix(i), back_poses.matrix(i), depth.size());
      intersect(visible, landing(seen, {first.valid, first.valid}, back));
      Bounds kept = visible;
      intersect(kept, reliable);
      kept_tally.add(kept, Golden(file, "cumulative_mask").picture<ValidityMask>(i),
                     Golden(file, "stable_cumulative").picture<ValidityMask>(i));
      intersect(kept, official_front(normals, points, targets[i]));
      compare_final(points, kept, colour, targets[i], log_depth, file, i, final_tally);
    }
    kept_tally.expect_good();
    final_tally.expect_good();
  }
  EXPECT_GT(frames, 0);
}

/// The reference does not mask holes: their depth 0 is a point at the target camera's centre, which the source may see.
void mark_target_centre(const Camera& source, const Camera& target, Bounds& seen) {
  Eigen::Vector2d pixel;
  if (!project(source.intrinsics, target_from_source(source, target).translation, pixel)) return;
  for (const double dx : {-0.5, 0.5})
    for (const double dy : {-0.5, 0.5}) {
      const int x = static_cast<int>(std::floor(pixel.x() + dx)), y = static_cast<int>(std::floor(pixel.y() + dy));
      if (seen.least.contains(x, y)) seen.least(x, y) = seen.most(x, y) = 1;
    }
}

TEST_F(OcclusionParity, occlusion_dynamic_view) {
  int frames = 0;
  for (const auto& path : fixture_files(fixture_folder("occlusion"), "dynamic_view")) {
    SCOPED_TRACE(path.string());
    const SafeTensors file = SafeTensors::open(path.string());
    const Golden depths(file, "in.depths"), colours(file, "in.colors"), normals(file, "in.normals_world");
    const Golden fg(file, "in.fg"), reliable_all(file, "in.reliable"), k(file, "in.K"), ks(file, "in.intrinsic_target");
    const Golden source_poses(file, "in.c2ws_source"), target_poses(file, "in.c2ws_target");
    const Size size{static_cast<int>(depths.dimension(1)), static_cast<int>(depths.dimension(2))};
    std::vector<Camera> sources, targets;
    float log_depth = 0;
    for (std::size_t i = 0; i < depths.shape().at(0); ++i) {
      sources.push_back(reference_camera(k.matrix(), source_poses.matrix(i), size));
      targets.push_back(reference_camera(ks.matrix(i), target_poses.matrix(i), size));
      const auto depth = depths.picture<DepthMap>(i);
      log_depth = std::max(log_depth, log_depth_max({sources[i], &depth, nullptr, nullptr}, targets[i]));
    }
    Bounds visible{ValidityMask(size, 1), ValidityMask(size, 1)};
    BoundsTally kept_tally, final_tally;
    for (std::size_t i = 0; i < targets.size(); ++i, ++frames) {
      SCOPED_TRACE("frame " + std::to_string(i));
      const auto depth = depths.picture<DepthMap>(i);
      const auto foreground = fg.picture<ValidityMask>(i);
      const auto reliable = reliable_all.picture<ValidityMask>(i);
      const PointGrid points{sources[i], &depth, nullptr, &reliable};
      const ValidityMask front = official_front(normals.interleaved<Eigen::Vector3f>(i), points, targets[i]);
      Bounds moving{foreground, foreground};
      intersect(moving, reliable);
      intersect(moving, front);
      const Bounds landed = landing(points, moving, targets[i]);
      const SoftSplat first = splat(points, nullptr, targets[i], log_depth);

      // Unprojected with frame 0's intrinsics, whatever the zoom. Where more of the foreground lands, less comes back.
      Camera unprojecting = targets[i];
      unprojecting.intrinsics = targets[0].intrinsics;
      const auto inverse = [](const ValidityMask& mask) {
        return to_validity(GenerateMask(Image<std::uint8_t>(mask)));
      };
      Bounds seen = landing({unprojecting, &first.depth, nullptr, nullptr},
                            {inverse(landed.most), inverse(landed.least)}, sources[i]);
      mark_target_centre(sources[i], targets[i], seen);
      intersect(visible, seen);
      unite(visible.least, foreground);
      unite(visible.most, foreground);
      Bounds kept = visible;
      intersect(kept, reliable);
      kept_tally.add(kept, Golden(file, "cumulative_mask").picture<ValidityMask>(i),
                     Golden(file, "stable_cumulative").picture<ValidityMask>(i));
      intersect(kept, front);
      compare_final(points, kept, colours.interleaved<RgbF>(i), targets[i], log_depth, file, i, final_tally);
    }
    kept_tally.expect_good();
    final_tally.expect_good();
  }
  EXPECT_GT(frames, 0);
}

}  // namespace
}  // namespace uwv::testing
