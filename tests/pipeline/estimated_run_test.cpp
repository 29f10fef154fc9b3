// SPDX-License-Identifier: Apache-2.0
// Runs over clips that come without depth: what is estimated, kept, found again and used again.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "pipeline/filmed_room.h"
#include "uwv/io/depth_source.h"
#include "uwv/io/frame_source.h"
#include "uwv/io/npy.h"
#include "uwv/pipeline/run.h"

namespace uwv {
namespace {

namespace fs = std::filesystem;
using test::WarningMonitor;
using ::testing::HasSubstr;

using EstimatedRun = test::FilmedRoom;

TEST_F(EstimatedRun, MeasuresDepthWhereTheCameraMoved) {
  film(9, 1.5);
  WarningMonitor monitor;
  const RunSummary first = run(options_, monitor);
  ASSERT_EQ(first.stages[0].name, "geometry");
  EXPECT_EQ(first.stages[0].status, StageSummary::Status::done);
  EXPECT_EQ(first.stages[0].facts["provider"], "sfm") << first.stages[0].facts.dump(1);
  EXPECT_EQ(first.stages[0].facts["frames"], 9);
  EXPECT_GT(first.stages[0].facts["multi_view_stereo"]["measured_share"], 0.3);
  EXPECT_GT(first.stages[1].facts["valid_share"], 0.5);
  EXPECT_LT(depth_error(), 0.06);
  for (const char* file : {"depth.npz", "confidence.npz", "cameras.json", "geometry.json"})
    EXPECT_TRUE(fs::exists(options_.out + "/geometry/" + file)) << file;

  const RunSummary again = run(options_, monitor);
  EXPECT_EQ(again.stages[0].status, StageSummary::Status::resumed);
  EXPECT_EQ(again.stages[1].status, StageSummary::Status::resumed);

  options_.traj = "right";
  const RunSummary other_path = run(options_, monitor);
  EXPECT_EQ(other_path.stages[0].status, StageSummary::Status::resumed) << "the path does not change the scene";
  EXPECT_EQ(other_path.stages[1].status, StageSummary::Status::done);

  options_.mvs_planes = 48;
  const RunSummary other_depth = run(options_, monitor);
  EXPECT_EQ(other_depth.stages[0].status, StageSummary::Status::done);
  EXPECT_EQ(other_depth.stages[1].status, StageSummary::Status::done) << "what builds on it is made anew";

  options_.mvs_planes = RunOptions{}.mvs_planes;
  const std::string depth = options_.out + "/geometry";
  options_.depth = depth;
  options_.out = folder_.file("second");
  const RunSummary reused = run(options_, monitor);
  EXPECT_EQ(reused.stages[0].reason, "--depth is given");
  EXPECT_EQ(reused.stages[1].facts["frames"], 9);
  options_.start = 1;
  EXPECT_THAT(error_of_run(), HasSubstr("geometry of 9 frames from 0 on"));
}

TEST_F(EstimatedRun, PlacesWhatMovesAndCompletesWhatItHides) {
  film(moving_ball({.size = {320, 184}}), 11, 1.5, 0.1);
  Monitor monitor;
  const nlohmann::ordered_json facts = run(options_, monitor).stages[0].facts;
  ASSERT_EQ(facts["provider"], "sfm") << facts.dump(1);
  EXPECT_GT(facts["moving_pixels"]["share"], 0.02) << facts.dump(1);
  EXPECT_THAT(facts["moving_pixels"]["foreground"].get<std::string>(), HasSubstr("motion decides"));
  EXPECT_GT(facts["background"]["seen_in_other_frames_share"], 0.02) << facts.dump(1);
  EXPECT_LT(facts["background"]["invented_share"], 0.05) << facts.dump(1);
  for (const char* file : {"foreground_mask.mp4", "background.mp4", "background_depth.npz"})
    EXPECT_TRUE(fs::exists(options_.out + "/geometry/" + file)) << file;
  options_.layers = LayerChoice::off;
  options_.out = folder_.file("flat");
  const nlohmann::ordered_json flat = run(options_, monitor).stages[0].facts;
  EXPECT_EQ(flat["background"], "skipped: --layers off");
  EXPECT_FALSE(fs::exists(options_.out + "/geometry/background.mp4"));
}

TEST_F(EstimatedRun, WhatWasMeasuredDecidesAgainWhenTheGeometryIsReused) {
  film(9, 1.5);
  options_.follow_source = true;
  Monitor monitor;
  run(options_, monitor);
  const nlohmann::json first = record();
  EXPECT_EQ(first["scene_profile"]["motion"], "moving");
  EXPECT_GT(first["scene_profile"]["measured_share"], 0.3);
  EXPECT_GT(first["scene_profile"]["parallax_per_frame_px"], 0);
  EXPECT_EQ(first["choices"]["cloud"]["choice"], "merged") << first["choices"].dump(1);
  EXPECT_EQ(first["choices"]["key_stride"]["forced"], false);
  EXPECT_THAT(first["choices"]["key_stride"]["saves"].get<std::string>(), HasSubstr("of 9 frames"));

  options_.depth = options_.out + "/geometry";
  options_.out = folder_.file("second");
  const RunSummary reused = run(options_, monitor);
  EXPECT_EQ(record()["scene_profile"], first["scene_profile"]);
  EXPECT_EQ(record()["choices"], first["choices"]);
  EXPECT_GT(reused.stages[1].facts["other_frames"]["filled_share"], 0);

  // A folder of an older build, which says nothing of all this, is looked at as given depth is.
  const std::string description = options_.depth + "/geometry.json";
  std::ofstream(description) << R"({"start": 0, "stride": 1, "frames": 9})";
  options_.out = folder_.file("third");
  run(options_, monitor);
  EXPECT_EQ(record()["scene_profile"]["motion"], "moving");
  EXPECT_EQ(record()["choices"]["key_stride"]["reason"], "the geometry folder does not say");
  // One that was tampered with is as good as one that says nothing.
  std::ofstream(description)
      << R"({"start": 0, "stride": 1, "frames": 9, "provider": 7, "key_stride": {"choice": "x"},)"
         R"( "profile": {"motion": [], "cuts": 1e300, "moving_share": -4, "parallax_px": "a"}})";
  options_.out = folder_.file("fourth");
  run(options_, monitor);
  EXPECT_EQ(record()["choices"]["cloud"]["choice"], "per_frame");
}

TEST_F(EstimatedRun, AssumesTheDepthOfOtherShots) {
  film(9, 1.5);
  ThreadPool pool;
  const StockScene other = sphere_floor_wall({.size = {240, 136}});
  for (int i = 9; i < 13; ++i)
    write_png(folder_.file(fmt::format("clip/{:03}.png", i)), render(other.scene, other.source, 0, pool, 2).colour);
  WarningMonitor monitor;
  const RunSummary summary = run(options_, monitor);
  const auto& facts = summary.stages[0].facts;
  EXPECT_EQ(facts["provider"], "sfm") << facts.dump(1);
  EXPECT_EQ(facts["frames"], 13);
  EXPECT_EQ(facts["other_shots"]["frames_of_the_shot"], 9);
  EXPECT_EQ(facts["other_shots"]["frames_of_others"], 4);
  EXPECT_EQ(facts["profile"]["cuts"], 1);
  EXPECT_THAT(monitor.warnings, ::testing::Contains(HasSubstr("cuts at 1 place")));
  EXPECT_LT(depth_error(), 0.06) << "the shot is measured as if it were alone";
  NpyArrayReader confidence(options_.out + "/geometry/confidence.npz", "confidence");
  ASSERT_EQ(confidence.slices(), 13U);
  std::vector<float> values(confidence.slice_values());
  for (const std::size_t frame : {9U, 12U}) {
    confidence.read(frame, std::span<float>(values));
    EXPECT_LT(*std::max_element(values.begin(), values.end()), 0.35F * 255) << "a guess that says so";
    EXPECT_GT(*std::min_element(values.begin(), values.end()), 0) << "and none of it is unknown";
  }
}

TEST_F(EstimatedRun, TakesTheBackgroundItIsGiven) {
  film(2, 0);
  for (const char* name : {"masks", "behind"}) fs::create_directory(folder_.file(name));
  ImageRgb mask(Size{240, 136});
  for (int y = 40; y < 100; ++y)
    for (int x = 90; x < 150; ++x) mask(x, y) = {255, 255, 255};
  for (int i = 0; i < 2; ++i) {
    write_png(folder_.file(fmt::format("masks/{}.png", i)), mask);
    write_png(folder_.file(fmt::format("behind/{}.png", i)), ImageRgb(Size{240, 136}, Rgb8{200, 40, 60}));
  }
  options_.foreground = folder_.file("masks");
  options_.background = folder_.file("behind");
  Monitor monitor;
  const RunSummary summary = run(options_, monitor);
  EXPECT_EQ(summary.stages[0].facts["background"]["given"], options_.background);
  ClipOptions as_is;
  as_is.resize.mode = ResizePolicy::Mode::none;
  const auto behind = open_clip(options_.out + "/geometry/background.mp4", as_is, monitor);
  ImageRgb picture;
  ASSERT_TRUE(behind->read(1, picture));
  EXPECT_NEAR(picture(120, 70).r, 200, 6);
  EXPECT_NEAR(picture(120, 70).g, 40, 6);

  fs::remove(folder_.file("behind/1.png"));
  EXPECT_THAT(error_of_run(), HasSubstr("found 1 background pictures, wanted 2"));
}

TEST_F(EstimatedRun, ShowsAGivenBackgroundBehindGivenDepth) {
  // A square before a wall. From the left the camera sees the wall behind it, of which the picture shows nothing.
  const Size size{240, 136};
  DepthMap depth(size, 4.0F);
  ImageRgb mask(size);
  for (int y = 40; y < 100; ++y)
    for (int x = 90; x < 150; ++x) depth(x, y) = 2, mask(x, y) = {255, 255, 255};
  write_png(folder_.file("clip.png"), ImageRgb(size, Rgb8{90, 90, 90}));
  write_png(folder_.file("behind.png"), ImageRgb(size, Rgb8{200, 40, 60}));
  write_png(folder_.file("mask.png"), mask);
  const std::vector<std::size_t> shape = {1, 136, 240};
  write_npy<float>(folder_.file("depth.npy"), shape, depth.pixels());
  write_npy<float>(folder_.file("far.npy"), shape, DepthMap(size, 4.0F).pixels());
  options_.video = folder_.file("clip.png");
  options_.depth = folder_.file("depth.npy");
  options_.foreground = folder_.file("mask.png");
  options_.out = folder_.file("out");
  options_.traj = "left";
  options_.fov = 60;
  options_.frames = 3;
  options_.no_resize = true;
  options_.renderer = RendererChoice::cpu;
  Monitor monitor;
  const double without = run(options_, monitor).stages[1].facts["valid_share"];
  options_.foreground_ring = true;
  const double ringed = run(options_, monitor).stages[1].facts["valid_share"];
  // Twelve pixels to each side of the square, in two of three frames: the first is the source picture itself.
  const double ring = 2.0 / 3 * (84 * 84 - 60 * 60) / (240 * 136);
  EXPECT_NEAR(without - ringed, ring, 0.2 * ring);
  options_.foreground_ring = false;
  options_.background = folder_.file("behind.png");
  EXPECT_THROW(options_.check(), std::invalid_argument) << "its depth is missing";
  options_.background_depth = folder_.file("far.npy");
  options_.layers = LayerChoice::on;
  const RunSummary with = run(options_, monitor);
  EXPECT_GT(with.stages[1].facts["background_share"], 0.01) << with.stages[1].facts.dump(1);
  EXPECT_GT(with.stages[1].facts["valid_share"], without + 0.01);
}

TEST_F(EstimatedRun, KeyFramesAsToldAndRecorded) {
  film(9, 1.5);
  options_.mvs_key_stride = 4;
  Monitor monitor;
  const RunSummary summary = run(options_, monitor);
  EXPECT_EQ(summary.stages[0].facts["multi_view_stereo"]["matched_frames"], 3);
  EXPECT_EQ(record()["choices"]["key_stride"]["choice"], 4);
  EXPECT_EQ(record()["choices"]["key_stride"]["forced"], true);
}

TEST_F(EstimatedRun, TheBackgroundIsDrawnWhereThePathNeedsIt) {
  film(1, 0);
  options_.frames = 4;
  Monitor monitor;
  run(options_, monitor);
  ASSERT_TRUE(fs::exists(options_.out + "/geometry/background.mp4"));
  EXPECT_EQ(record()["choices"]["layers"]["choice"], "on") << record()["choices"].dump(1);
  options_.depth = options_.out + "/geometry";
  options_.traj = "still";
  options_.out = folder_.file("second");
  const RunSummary still = run(options_, monitor);
  EXPECT_EQ(record()["choices"]["layers"]["choice"], "off");
  EXPECT_THAT(still.stages[1].facts["background_layer"].get<std::string>(), HasSubstr("uncovers only 0.0 %"));
  options_.layers = LayerChoice::on;
  options_.out = folder_.file("third");
  EXPECT_EQ(run(options_, monitor).stages[1].facts["background_layer"], "drawn");
  EXPECT_EQ(record()["choices"]["layers"]["forced"], true);
}

TEST_F(EstimatedRun, SaysThatDepthIsAPriorWhereTheCameraStoodStill) {
  film(5, 0);
  WarningMonitor monitor;
  const RunSummary summary = run(options_, monitor);
  EXPECT_EQ(summary.stages[0].facts["provider"], "prior") << summary.stages[0].facts.dump(1);
  EXPECT_THAT(monitor.warnings, ::testing::Contains(HasSubstr("prior")));
  EXPECT_GT(summary.stages[1].facts["valid_share"], 0.3);
  options_.geometry = GeometryChoice::sfm;
  EXPECT_THAT(error_of_run(), HasSubstr("cannot be measured"));
}

TEST_F(EstimatedRun, DrawsAnewWhenLayersAreTurnedOff) {
  film(3, 0);
  Monitor monitor;
  run(options_, monitor);
  options_.depth = options_.out + "/geometry";
  options_.out = folder_.file("second");
  run(options_, monitor);
  options_.layers = LayerChoice::off;
  EXPECT_EQ(run(options_, monitor).stages[1].status, StageSummary::Status::done);
}

TEST_F(EstimatedRun, BringsRelativeDepthToTheScaleOfTheCameras) {
  film(9, 1.5);
  std::vector<float> relative;
  for (std::size_t i = 0; i < depths_.size(); ++i)  // another line in each frame, as networks deliver it
    for (const float z : depths_[i].pixels()) relative.push_back((2.0F + 0.1F * static_cast<float>(i % 3)) / z + 0.3F);
  write_npy<float>(
      folder_.file("relative.npy"),
      {depths_.size(), static_cast<std::size_t>(depths_[0].height()), static_cast<std::size_t>(depths_[0].width())},
      relative);
  options_.depth = folder_.file("relative.npy");
  options_.depth_kind = DepthKind::relative_inverse;
  Monitor monitor;
  const RunSummary summary = run(options_, monitor);
  EXPECT_EQ(summary.stages[0].facts["alignment"]["solved_frames"], 9) << summary.stages[0].facts.dump(1);
  EXPECT_LT(depth_error(), 0.04) << "the relative depth was exact but for its lines";
}

TEST_F(EstimatedRun, FitsDepthWhoseUnitJumpsFrameByFrameWhenTold) {
  film(9, 1.5);
  std::vector<float> relative;
  for (std::size_t i = 0; i < depths_.size(); ++i)
    for (const float z : depths_[i].pixels()) relative.push_back((i % 2 == 0 ? 2.0F : 3.0F) * z);
  write_npy<float>(
      folder_.file("relative.npy"),
      {depths_.size(), static_cast<std::size_t>(depths_[0].height()), static_cast<std::size_t>(depths_[0].width())},
      relative);
  options_.depth = folder_.file("relative.npy");
  options_.depth_kind = DepthKind::relative_depth;
  Monitor monitor;
  run(options_, monitor);
  const double joint = depth_error();
  options_.depth_smoothing = AlignmentSmoothing::none;
  EXPECT_EQ(run(options_, monitor).stages[0].status, StageSummary::Status::done);
  const double alone = depth_error();
  EXPECT_LT(alone, 0.06);
  EXPECT_GT(joint, 1.5 * alone) << "else this option has no use";
}

TEST_F(EstimatedRun, TakesInverseDepthAsTold) {
  film(2, 1.5);
  std::vector<float> inverse;
  for (const DepthMap& depth : depths_)
    for (const float z : depth.pixels()) inverse.push_back(z > 0 ? 1 / z : 0);
  write_npy<float>(
      folder_.file("inverse.npy"),
      {depths_.size(), static_cast<std::size_t>(depths_[0].height()), static_cast<std::size_t>(depths_[0].width())},
      inverse);
  options_.depth = folder_.file("inverse.npy");
  options_.depth_kind = DepthKind::inverse;
  options_.frames = 1;
  Monitor monitor;
  run(options_, monitor);
  DepthMap depth;
  ASSERT_TRUE(open_depth(options_.out + "/depth.npz", {}, monitor)->read(0, depth));
  EXPECT_NEAR(depth(120, 68), depths_[0](120, 68), 1e-5 * depths_[0](120, 68)) << "the first frame is the source";
}

TEST_F(EstimatedRun, LeavesNothingBehindWhenStopped) {
  film(4, 1.5);
  class StopAt : public Monitor {
   public:
    explicit StopAt(std::string_view stage) : stage_(stage) {}
    bool progress(std::string_view stage, long, long) override { return stage != stage_; }

   private:
    std::string stage_;
  };
  for (const char* stage : {"reading", "tracking"}) {
    StopAt monitor(stage);
    EXPECT_THROW(run(options_, monitor), Error) << stage;
    EXPECT_FALSE(fs::exists(options_.out)) << stage;
  }
}

TEST_F(EstimatedRun, ChecksThePathBeforeItEstimatesAnything) {
  film(3, 1.5);
  options_.traj = "lefft";
  class NeverReads : public Monitor {
   public:
    bool progress(std::string_view stage, long, long) override {
      ADD_FAILURE() << stage;
      return true;
    }
  } monitor;
  EXPECT_THROW(run(options_, monitor), Error);
}

}  // namespace
}  // namespace uwv
