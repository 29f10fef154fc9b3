// SPDX-License-Identifier: Apache-2.0
// The soft splat against the official BiSplatRenderer and Warper. Cases are whatever the folder holds:
//   splat/<scene>/scene.safetensors with render_<what>.safetensors, where <what> may name `normals`, `mask`, and
//   `camera<i>_alone` (a batch of one); splat/warper/<scene>_warp[_mask1].safetensors.
#include <gtest/gtest.h>

#include <regex>

#include "support/fixture_tensors.h"
#include "support/matchers.h"
#include "support/rounding_bounds.h"

namespace uwv::testing {
namespace {

/// One scene.safetensors as a grid with colours.
struct GoldenScene {
  Camera source;
  DepthMap depth;
  ImageRgbF colour;
  ValidityMask mask;
  NormalMap normals;
  std::vector<Camera> targets;

  explicit GoldenScene(const std::string& path) {
    const SafeTensors file = SafeTensors::open(path);
    depth = Golden(file, "depth").picture<DepthMap>();
    colour = Golden(file, "colors").interleaved<RgbF>();
    mask = Golden(file, "mask").picture<ValidityMask>();
    source = reference_camera(Golden(file, "K").matrix(), Golden(file, "c2w_source").matrix(), depth.size());
    normals = Golden(file, "normals_world").interleaved<Eigen::Vector3f>();
    const Golden poses(file, "c2ws_target"), ks(file, "Ks_target");
    for (std::size_t i = 0; i < poses.shape().at(0); ++i)
      targets.push_back(reference_camera(ks.matrix(i), poses.matrix(i), depth.size()));
  }
};

class SplatParity : public ::testing::Test {
 protected:
  ThreadPool pool_;
  std::unique_ptr<Rasterizer> rasterizer_ = make_cpu_rasterizer(pool_);
};

TEST_F(SplatParity, splat_every_render_of_every_scene) {
  int renders = 0;
  for (const auto& folder : std::filesystem::directory_iterator(fixture_folder("splat"))) {
    if (!std::filesystem::exists(folder.path() / "scene.safetensors")) continue;
    const GoldenScene scene((folder.path() / "scene.safetensors").string());
    for (const auto& path : fixture_files(folder.path(), "render_")) {
      SCOPED_TRACE(path.string());
      const std::string name = path.stem().string();
      const SafeTensors file = SafeTensors::open(path.string());
      const Golden render(file, "render");
      std::smatch alone;
      std::vector<std::size_t> cameras;
      if (std::regex_search(name, alone, std::regex("camera([0-9]+)_alone")))
        cameras.push_back(std::stoul(alone[1]));
      else
        for (std::size_t i = 0; i < render.shape().at(0); ++i) cameras.push_back(i);
      PointGrid grid{scene.source, &scene.depth, nullptr, nullptr};
      SoftSplatOptions options;
      for (const std::size_t c : cameras)
        options.log_depth_max = std::max(options.log_depth_max, log_depth_max(grid, scene.targets.at(c)));
      BoundsTally tally;
      for (std::size_t i = 0; i < cameras.size(); ++i) {
        SCOPED_TRACE("camera " + std::to_string(cameras[i]));
        const Camera& target = scene.targets.at(cameras[i]);
        ValidityMask keep(scene.depth.size(), 1);
        if (name.find("mask") != std::string::npos) keep = scene.mask;
        if (name.find("normals") != std::string::npos) intersect(keep, official_front(scene.normals, grid, target));
        grid.keep = &keep;
        SoftSplat ours;
        rasterizer_->soft_splat(grid, &scene.colour, target, options, ours);
        const auto mask = Golden(file, "mask").picture<ValidityMask>(i);
        // Without a `stable` map every golden pixel counts.
        const ValidityMask stable = file.has("stable") ? Golden(file, "stable").picture<ValidityMask>(i) : mask;
        const auto depth = file.has("depth") ? Golden(file, "depth").picture<DepthMap>(i) : DepthMap();
        const Bounds bounds = landing_bounds(*rasterizer_, grid, {keep, keep}, target);
        tally.add(bounds, mask, stable);
        ValidityMask comparable = stable;
        for (std::size_t p = 0; p < stable.size().pixels(); ++p)
          comparable.data()[p] &= bounds.least.data()[p] == bounds.most.data()[p];
        expect_matches_golden(ours, mask, render, i, comparable, depth.empty() ? nullptr : &depth);
        ++renders;
      }
      tally.expect_good();
    }
  }
  EXPECT_GT(renders, 0) << "no scene found in " << fixture_folder("splat");
}

/// The Warper differs from the renderer in two ways: points behind the camera are drawn mirrored (frames with such
/// points are left out here, since ours never draws them), and holes are 0.
TEST_F(SplatParity, splat_every_forward_warp_with_all_points_in_front) {
  int frames = 0;
  const std::filesystem::path folder = std::filesystem::path(fixture_folder("splat")) / "warper";
  for (const auto& path : fixture_files(folder, "")) {
    const std::string name = path.stem().string();
    std::smatch parts;
    if (!std::regex_match(name, parts, std::regex("(.+)_warp(_mask1)?"))) continue;
    SCOPED_TRACE(path.string());
    const GoldenScene scene((folder.parent_path() / parts[1].str() / "scene.safetensors").string());
    const SafeTensors file = SafeTensors::open(path.string());
    const Golden warped(file, "warped"), k2(file, "in.intrinsic2"), k1(file, "in.intrinsic1");
    const Golden w2c1(file, "in.transformation1"), w2c2(file, "in.transformation2");
    const std::size_t count = warped.shape().at(0);
    std::vector<PointGrid> grids;
    std::vector<Camera> targets;
    SoftSplatOptions options;
    for (std::size_t i = 0; i < count; ++i) {
      Camera source = reference_camera(k1.matrix(i), w2c1.matrix(i), scene.depth.size());
      source.world_from_cam = source.world_from_cam.inverse();
      Camera target = reference_camera(k2.matrix(i), w2c2.matrix(i), scene.depth.size());
      target.world_from_cam = target.world_from_cam.inverse();
      grids.push_back({source, &scene.depth, nullptr, parts[2].matched ? &scene.mask : nullptr});
      targets.push_back(target);
      options.log_depth_max = std::max(options.log_depth_max, log_depth_max(grids.back(), target));
    }
    for (std::size_t i = 0; i < count; ++i) {
      const Rigid3 motion = target_from_source(targets[i], grids[i].camera);
      bool all_in_front = true;
      for (int y = 0; y < scene.depth.height(); ++y)
        for (int x = 0; x < scene.depth.width(); ++x)
          all_in_front &=
              (motion * unproject(grids[i].camera.intrinsics, {x + 0.5, y + 0.5}, scene.depth(x, y))).z() > 0;
      if (!all_in_front) continue;
      SCOPED_TRACE("frame " + std::to_string(i));
      SoftSplat ours;
      rasterizer_->soft_splat(grids[i], &scene.colour, targets[i], options, ours);
      const auto mask = Golden(file, "second").picture<ValidityMask>(i);
      std::size_t agree = 0, close = 0, both = 0;
      for (std::size_t p = 0; p < mask.size().pixels(); ++p) {
        agree += mask.data()[p] == ours.valid.data()[p];
        if (mask.data()[p] == 0 || ours.valid.data()[p] == 0) continue;
        ++both;
        const std::size_t at = i * 3 * mask.size().pixels() + p;
        close += std::fabs(ours.colour.data()[p].r - warped.at(at)) <= 1e-3 &&
                 std::fabs(ours.colour.data()[p].g - warped.at(at + mask.size().pixels())) <= 1e-3 &&
                 std::fabs(ours.colour.data()[p].b - warped.at(at + 2 * mask.size().pixels())) <= 1e-3;
      }
      EXPECT_GE(agree, mask.size().pixels() * 97 / 100);
      EXPECT_GE(close, both * 97 / 100) << close << " of " << both << " pixels within 1e-3";
      ++frames;
    }
  }
  EXPECT_GT(frames, 0) << "no warp found in " << folder;
}

}  // namespace
}  // namespace uwv::testing
