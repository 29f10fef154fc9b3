// SPDX-License-Identifier: Apache-2.0
// What `uwv_bench geometry` judges with: scores, clips with truth, and COLMAP as another program.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "bench/child_process.h"
#include "bench/colmap.h"
#include "bench/geometry_scores.h"
#include "support/temp_folder.h"
#include "uwv/eval/stock_scenes.h"
#include "uwv/io/cameras_file.h"
#include "uwv/io/depth_file.h"
#include "uwv/io/depth_writer.h"
#include "uwv/io/image_file.h"

namespace uwv::bench {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

constexpr double degree = std::numbers::pi / 180;

Eigen::Matrix3d turned(const Vector3d& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

/// A bent path with the camera turning on the way.
std::vector<Camera> path(int frames) {
  std::vector<Camera> cameras;
  for (int i = 0; i < frames; ++i) {
    const Rigid3 pose{turned({1, 3, 2}, 0.05 * i), {0.3 * i, std::sin(0.4 * i), 0.02 * i * i}};
    cameras.push_back({{500, 500, 320, 240}, pose, {640, 480}});
  }
  return cameras;
}

/// The same cameras in a frame that is turned, moved and has another unit.
std::vector<Camera> in_another_frame(std::vector<Camera> cameras) {
  const Rigid3 frame{turned({2, -1, 1}, 2.5), {7, -5, 3}};
  for (Camera& camera : cameras) {
    camera.world_from_cam = frame * camera.world_from_cam;
    camera.world_from_cam.translation *= 0.25;
  }
  return cameras;
}

TEST(CameraScore, FrameAndScaleOfAReconstructionDoNotMatter) {
  const CameraScore score = score_cameras(in_another_frame(path(20)), {}, path(20));
  EXPECT_EQ(score.cameras, 20);
  EXPECT_LT(score.ate, 1e-12);
  EXPECT_LT(score.rotation_deg, 1e-5);  // an angle's cosine is no finer near 1
  EXPECT_NEAR(score.scale, 4, 1e-12);
  EXPECT_EQ(score.focal_percent, 0);
}

TEST(CameraScore, ErrorsComeOutAsTheyWentIn) {
  std::vector<Camera> found = path(21);
  // Alternating sideways errors, which no similarity takes out but for a trace.
  for (std::size_t i = 0; i < found.size(); ++i) {
    found[i].world_from_cam.translation.y() += i % 2 == 0 ? 0.01 : -0.01;
    const Eigen::Matrix3d wrong = turned({1, 0, 0}, (i % 2 == 0 ? 2 : -2) * degree);
    found[i].world_from_cam.rotation = found[i].world_from_cam.rotation * wrong;
    found[i].intrinsics.fx = 550;
  }
  const CameraScore score = score_cameras(in_another_frame(found), {}, path(21));
  EXPECT_NEAR(score.ate, 0.01, 5e-4);
  EXPECT_NEAR(score.rotation_deg, 2, 0.05);
  EXPECT_NEAR(score.focal_percent, 10, 1e-9);
}

TEST(CameraScore, UnregisteredCamerasAreNotJudged) {
  std::vector<Camera> found = path(10);
  std::vector<std::uint8_t> registered(10, 1);
  found[4].world_from_cam.translation = {100, 100, 100};
  EXPECT_GT(score_cameras(found, registered, path(10)).ate, 1);
  registered[4] = 0;
  EXPECT_LT(score_cameras(found, registered, path(10)).ate, 1e-12);
}

TEST(CameraScore, StraightPathLeavesOrientationsJudged) {
  std::vector<Camera> straight = path(8);
  for (std::size_t i = 0; i < straight.size(); ++i)
    straight[i].world_from_cam.translation = {static_cast<double>(i), 0, 0};
  const CameraScore score = score_cameras(in_another_frame(straight), {}, straight);
  EXPECT_LT(score.ate, 1e-12);
  EXPECT_LT(score.rotation_deg, 1e-5);
}

TEST(CameraScore, TwoCamerasTellNothing) {
  EXPECT_TRUE(std::isnan(score_cameras(path(2), {}, path(2)).ate));
  EXPECT_TRUE(std::isnan(score_cameras({}, {}, path(5)).ate));
}

TrueClip flat_clip(int frames) {
  TrueClip clip;
  const Size size{8, 2};
  for (int i = 0; i < frames; ++i) {
    clip.frames.emplace_back(size);
    clip.depths.emplace_back(size, 2.0F);
    clip.depths.back()(3, 1) = 0;  // not known
    clip.cameras.push_back({{8, 8, 4, 1}, {}, size});
  }
  return clip;
}

TEST(DepthScore, CountsAndScalesAsItSays) {
  TrueClip clip = flat_clip(1);
  FrameGeometry found{DepthMap(8, 2, 1.0F), ConfidenceMap(8, 2, 1.0F)};
  found.depth(0, 0) = 1.1F;
  found.confidence(0, 0) = 0.2F;
  found.depth(1, 0) = 0;
  found.depth(7, 1) = 1.5F;
  found.confidence(7, 1) = 0.49F;
  const std::vector<FrameGeometry> frames{found};
  const DepthScore score = score_depth(frames, clip, 0);
  EXPECT_NEAR(score.scale, 2, 1e-6);
  EXPECT_NEAR(score.abs_rel, 0.6 / 14, 1e-6);
  EXPECT_NEAR(score.measured_abs_rel, 0, 1e-12);
  EXPECT_NEAR(score.delta_125, 13.0 / 14, 1e-12);
  EXPECT_NEAR(score.known, 14.0 / 15, 1e-12);
  EXPECT_NEAR(score.measured, 12.0 / 15, 1e-12);
  EXPECT_EQ(score.edge_f, 0);
  EXPECT_TRUE(std::isnan(score.flicker));  // of one frame
  EXPECT_NEAR(score_depth(frames, clip, 1).abs_rel, (12 * 0.5 + 0.45 + 0.25) / 14, 1e-6);

  clip.static_pixels = {ValidityMask(8, 2, 1)};
  clip.static_pixels[0](0, 0) = clip.static_pixels[0](7, 1) = 0;
  const DepthScore at_rest = score_depth(frames, clip, 0);
  EXPECT_NEAR(at_rest.abs_rel, 0, 1e-12);
  EXPECT_EQ(at_rest.edge_f, 1);
}

TEST(DepthScore, OneScaleForTheClipLeavesItsFlicker) {
  const TrueClip clip = flat_clip(2);
  const std::vector<FrameGeometry> frames{{DepthMap(8, 2, 1.0F), ConfidenceMap(8, 2, 1.0F)},
                                          {DepthMap(8, 2, 1.1F), ConfidenceMap(8, 2, 1.0F)}};
  const DepthScore score = score_depth(frames, clip, 0);
  EXPECT_NEAR(score.flicker, 0.1, 1e-6);
  EXPECT_GT(score.abs_rel, 0.04);
}

TEST(DepthScore, NothingFoundIsNoFigure) {
  const TrueClip clip = flat_clip(1);
  const std::vector<FrameGeometry> nothing{{DepthMap(8, 2), ConfidenceMap(8, 2)}};
  const DepthScore score = score_depth(nothing, clip, 0);
  EXPECT_TRUE(std::isnan(score.abs_rel));
  EXPECT_TRUE(std::isnan(score.measured_abs_rel));
  EXPECT_EQ(score.known, 0);
  EXPECT_THROW(score_depth({}, clip, 0), std::invalid_argument);
}

/// Two views of a stock scene, in the layouts that are read.
class TrueClips : public testing::Test {
 protected:
  void SetUp() override {
    scene_ = boxes_room({.size = size});
    ThreadPool pool(2);
    for (int i = 0; i < 2; ++i) {
      Camera camera = scene_.source;
      camera.world_from_cam.translation.x() += 0.2 * i;
      camera.world_from_cam.rotation = camera.world_from_cam.rotation * turned({1, 2, 3}, 0.1 * i);
      cameras_.push_back(camera);
      views_.push_back(render(scene_.scene, camera, 0, pool));
    }
  }

  std::string make(const char* pictures) const {
    const fs::path root = folder_.path() / "clip";
    fs::create_directories(root / pictures);
    for (int i = 0; i < 2; ++i)
      write_png((root / pictures / fmt::format("{:05}.png", i)).string(), views_[static_cast<std::size_t>(i)].colour);
    return root.string();
  }

  void expect_same(const TrueClip& clip, double tolerance) const {
    ASSERT_EQ(clip.frames.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(clip.frames[i], views_[i].colour);
      EXPECT_LT((clip.cameras[i].world_from_cam.matrix() - cameras_[i].world_from_cam.matrix()).norm(), 1e-6);
      for (std::size_t k = 0; k < size.pixels(); ++k)
        ASSERT_NEAR(clip.depths[i].pixels()[k], views_[i].depth.pixels()[k], tolerance);
    }
  }

  static constexpr Size size{64, 48};
  test::TempFolder folder_;
  StockScene scene_;
  std::vector<Camera> cameras_;
  std::vector<SyntheticFrame> views_;
};

const ResizePolicy as_it_is = [] {
  ResizePolicy policy;
  policy.mode = ResizePolicy::Mode::none;
  return policy;
}();

TEST_F(TrueClips, SavedClipReadsBack) {
  const std::string root = make("image");
  Monitor monitor;
  const auto depths = make_depth_writer(root + "/depth.npz", {}, size, 2, monitor);
  for (const SyntheticFrame& view : views_) depths->write(view.depth);
  depths->finish();
  write_cameras(root + "/cameras.json", {cameras_, {0, 1}}, CamerasFormat::uwv);
  fs::create_directories(root + "/foreground");
  ImageRgb figure(size);
  figure(5, 6) = {255, 255, 255};
  for (const char* name : {"/foreground/00000.png", "/foreground/00001.png"}) write_png(root + name, figure);
  const TrueClip clip = read_true_clip(root, {}, as_it_is);
  expect_same(clip, 0);
  EXPECT_EQ(clip.cameras[1].intrinsics, cameras_[1].intrinsics);
  ASSERT_EQ(clip.static_pixels.size(), 2U);
  EXPECT_EQ(clip.static_pixels[1](5, 6), 0);
  EXPECT_EQ(clip.static_pixels[1].count(), size.pixels() - 1);
  EXPECT_EQ(read_true_clip(root, {0, 1, 1}, as_it_is).cameras.size(), 1U);
}

TEST_F(TrueClips, CamerasWithYUpAreTurnedOver) {
  const std::string root = make("color");
  fs::create_directories(root + "/depth");
  std::ofstream poses(root + "/pose.txt");
  poses.precision(12);
  const Vector3d flip(1, -1, 1);
  for (int i = 0; i < 2; ++i) {
    const auto k = static_cast<std::size_t>(i);
    write_depth_file(root + fmt::format("/depth/{}.png", i), views_[k].depth, {.scale = 1.0 / 5000, .key = ""});
    const Eigen::Matrix3d y_up = flip.asDiagonal() * cameras_[k].world_from_cam.rotation * flip.asDiagonal();
    const Eigen::Quaterniond turn(y_up);
    const Vector3d centre = flip.cwiseProduct(cameras_[k].world_from_cam.translation);
    poses << centre.x() << ' ' << centre.y() << ' ' << centre.z() << ' ' << turn.x() << ' ' << turn.y() << ' '
          << turn.z() << ' ' << turn.w() << '\n';
  }
  poses.close();
  const TrueClip clip = read_true_clip(root, {}, as_it_is);
  expect_same(clip, 2e-4);
  EXPECT_GT(clip.cameras[0].intrinsics.fy, 0);
}

TEST_F(TrueClips, FewerPosesThanPicturesAreAnError) {
  const std::string root = make("image");
  Monitor monitor;
  const auto depths = make_depth_writer(root + "/depth.npz", {}, size, 2, monitor);
  for (const SyntheticFrame& view : views_) depths->write(view.depth);
  depths->finish();
  write_cameras(root + "/cameras.json", {{cameras_[0]}, {0}}, CamerasFormat::uwv);
  EXPECT_THROW(read_true_clip(root, {}, as_it_is), Error);
}

TEST_F(TrueClips, ARangeTakesItsFramesWithTheirDepthsAndPoses) {
  const std::string root = make("image");
  Monitor monitor;
  const auto depths = make_depth_writer(root + "/depth.npz", {}, size, 2, monitor);
  for (const SyntheticFrame& view : views_) depths->write(view.depth);
  depths->finish();
  write_cameras(root + "/cameras.json", {cameras_, {0, 1}}, CamerasFormat::uwv);
  for (const FrameRange range : {FrameRange{1, 1, 0}, FrameRange{1, 5, 1}}) {
    const TrueClip clip = read_true_clip(root, range, as_it_is);
    ASSERT_EQ(clip.frames.size(), 1U);
    EXPECT_EQ(clip.frames[0], views_[1].colour);
    EXPECT_EQ(clip.depths[0], views_[1].depth);
    EXPECT_EQ(clip.cameras.at(0).world_from_cam.translation, cameras_[1].world_from_cam.translation);
  }
  EXPECT_THROW(read_true_clip(root, {2, 1, 0}, as_it_is), Error);
}

/// Two pictures and their disparities, 8 bits each.
class StereoPairs : public testing::Test {
 protected:
  std::string file(const char* name) const { return (folder_.path() / name).string(); }
  void make(const char* left, const char* right, const char* left_disparity, const char* right_disparity) const {
    ImageRgb picture(40, 30, {200, 100, 50}), disparity(40, 30, {60, 60, 60});
    disparity(3, 4) = {0, 0, 0};
    write_png(file(left), picture);
    write_png(file(right), picture);
    write_png(file(left_disparity), disparity);
    write_png(file(right_disparity), disparity);
  }
  TrueClip read() const { return read_true_clip(folder_.path().string(), {}, as_it_is); }
  test::TempFolder folder_;
};

TEST_F(StereoPairs, ProjectWhereTheirDisparitySays) {
  make("view1.png", "view5.png", "disp1.png", "disp5.png");
  const TrueClip clip = read();
  ASSERT_EQ(clip.frames.size(), 2U);
  EXPECT_EQ(clip.depths[0](3, 4), 0);
  for (const std::size_t side : {0U, 1U}) {
    const std::size_t other = 1 - side;
    const Eigen::Vector3d x_in_world =
        clip.cameras[side].world_from_cam *
        unproject(clip.cameras[side].intrinsics, {20.5, 10.5}, static_cast<double>(clip.depths[side](20, 10)));
    Eigen::Vector2d pixel;
    ASSERT_TRUE(project(clip.cameras[other].intrinsics, clip.cameras[other].cam_from_world() * x_in_world, pixel));
    // 60 halves of a pixel, to the left in the right picture.
    EXPECT_NEAR(pixel.x(), side == 0 ? 20.5 - 30 : 20.5 + 30, 1e-4);
    EXPECT_NEAR(pixel.y(), 10.5, 1e-6);
  }
}

TEST_F(StereoPairs, UnitsOfDisparityFollowTheLayout) {
  make("im2.png", "im6.png", "disp2.png", "disp6.png");
  EXPECT_NEAR(read().depths[1](20, 10), 40.0 / 15, 1e-5);
}

TEST_F(StereoPairs, WhatIsMissingOrOfAnotherSizeIsAnError) {
  EXPECT_THROW(read(), Error);
  make("im2.png", "im6.png", "disp2.png", "disp6.png");
  write_png(file("disp6.png"), ImageRgb(41, 30));
  EXPECT_THROW(read(), Error);
  write_png(file("disp6.png"), ImageRgb(40, 30));
  write_png(file("im6.png"), ImageRgb(40, 31));
  EXPECT_THROW(read(), Error);
  fs::remove(file("im6.png"));
  EXPECT_THROW(read(), Error);
}

TEST(TrueClip, FoldersOfSomethingElseAreAnError) {
  const test::TempFolder folder;
  EXPECT_THROW(read_true_clip(folder.path().string(), {}, as_it_is), Error);
  EXPECT_THROW(read_true_clip("no/such/folder", {}, as_it_is), Error);
}

TEST(ChildProcess, TellsHowItEnded) {
  const test::TempFolder folder;
  const std::string log = (folder.path() / "log.txt").string();
  EXPECT_TRUE(run_child({"sh", "-c", "echo $WORD >&2"}, {"WORD=hello"}, log, 10).ok());
  EXPECT_EQ(run_child({"sh", "-c", "exit 3"}, {}, log, 10).status, 3);
  EXPECT_FALSE(run_child({"no-such-program-anywhere"}, {}, log, 10).started);
  const ChildResult slow = run_child({"sleep", "60"}, {}, log, 0.1);
  EXPECT_TRUE(slow.timed_out);
  EXPECT_LT(slow.seconds, 10);
  EXPECT_EQ(folder.read("log.txt"), "hello\n");
}

/// A program named colmap that answers as COLMAP does.
class Colmap : public testing::Test {
 protected:
  void SetUp() override {
    old_path_ = ::getenv("PATH");
    ::setenv("PATH", (folder_.path().string() + ":" + old_path_).c_str(), 1);
  }
  void TearDown() override { ::setenv("PATH", old_path_.c_str(), 1); }

  void answer(const std::string& mapper, const std::string& converter) const {
    const fs::path program = folder_.path() / "colmap";
    std::ofstream file(program);
    file << "#!/bin/sh\nstep=$1\nwhile [ $# -gt 0 ]; do [ $1 = --output_path ] && out=$2; shift; done\n"
         << "case $step in\nmapper) " << mapper << ";;\nmodel_converter) " << converter << ";;\nesac\n";
    file.close();
    fs::permissions(program, fs::perms::owner_all);
  }
  ColmapResult run() const {
    const std::vector<ImageRgb> frames(3, ImageRgb(8, 6));
    return run_colmap(frames, (folder_.path() / "work").string(), {});
  }

  test::TempFolder folder_;
  std::string old_path_;
};

TEST_F(Colmap, ReadsPosesAndLens) {
  answer("mkdir $out/0 $out/1; echo a > $out/0/images.bin; echo larger > $out/1/images.bin",
         R"(printf '# cameras\n1 SIMPLE_PINHOLE 8 6 7.5 4 3\n' > $out/cameras.txt
            printf '# images\n1 0.5 0.5 0.5 0.5 1 2 3 1 00000.png\n1 1 -1\n' > $out/images.txt
            printf '2 1 0 0 0 0 0 -4 1 00002.png\n\n' >> $out/images.txt
            printf '# points\n1 0 0 0\n2 0 0 0\n' > $out/points3D.txt)");
  const ColmapResult result = run();
  EXPECT_EQ(result.failure, "");
  EXPECT_EQ(result.registered, (std::vector<std::uint8_t>{1, 0, 1}));
  EXPECT_EQ(result.points, 2U);
  EXPECT_EQ(result.cameras[0].intrinsics, (Intrinsics{7.5, 7.5, 4, 3}));
  // x -> z -> y -> x, then (1, 2, 3) added: cam_from_world.
  EXPECT_LT((result.cameras[0].cam_from_world() * Vector3d(1, 0, 0) - Vector3d(1, 3, 3)).norm(), 1e-12);
  EXPECT_LT((result.cameras[2].world_from_cam.translation - Vector3d(0, 0, 4)).norm(), 1e-12);
}

TEST_F(Colmap, FailuresAreSaid) {
  answer("exit 1", "");
  EXPECT_THAT(run().failure, testing::StartsWith("mapper failed"));
  answer("true", "");
  EXPECT_EQ(run().failure, "mapper made no model");
  answer("mkdir $out/0; echo a > $out/0/images.bin", "true");
  EXPECT_EQ(run().failure, "it registered no picture");
}

}  // namespace
}  // namespace uwv::bench
