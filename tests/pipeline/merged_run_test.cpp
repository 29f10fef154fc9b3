// SPDX-License-Identifier: Apache-2.0
// Runs over a clip with a moving camera and known geometry: what single frames leave open is filled from other frames.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "support/temp_folder.h"
#include "uwv/eval/image_metrics.h"
#include "uwv/eval/stock_scenes.h"
#include "uwv/io/cameras_file.h"
#include "uwv/io/frame_source.h"
#include "uwv/io/image_file.h"
#include "uwv/io/npy.h"
#include "uwv/pipeline/run.h"

namespace uwv {
namespace {

using ::testing::HasSubstr;

class MergedRun : public ::testing::Test {
 protected:
  static constexpr Size size{240, 136};

  /// A room past which the camera moves by `step_deg` of an orbit a frame, with its true depth and cameras.
  void film(int frames, double step_deg) {
    room_ = boxes_room({.size = size});
    std::vector<float> depths;
    CameraTrack track;
    std::filesystem::create_directory(folder_.file("clip"));
    for (int i = 0; i < frames; ++i) {
      const Camera camera = orbit_camera(room_.source, room_.subject_in_world, i * step_deg * M_PI / 180);
      const SyntheticFrame frame = render(room_.scene, camera, 0, pool_, 2);
      write_png(folder_.file(fmt::format("clip/{:03}.png", i)), frame.colour);
      depths.insert(depths.end(), frame.depth.pixels().begin(), frame.depth.pixels().end());
      track.cameras.push_back(camera);
      track.times.push_back(i);
    }
    write_npy<float>(folder_.file("depth.npy"), {static_cast<std::size_t>(frames), size.height, size.width}, depths);
    write_cameras(folder_.file("cameras.json"), track, CamerasFormat::uwv);
    options_.video = folder_.file("clip");
    options_.depth = folder_.file("depth.npy");
    options_.cameras = folder_.file("cameras.json");
    options_.no_resize = true;
    options_.traj = "left";
    options_.follow_source = true;
    options_.contact_sheet = 0;
    options_.crf = 0;
    options_.renderer = RendererChoice::cpu;
  }

  RunSummary run_into(const std::string& out, CloudChoice cloud) {
    options_.cloud = cloud;
    options_.out = folder_.file(out);
    Monitor monitor;
    return run(options_, monitor);
  }

  nlohmann::json record() const {
    std::ifstream file(options_.out + "/run.json");
    return nlohmann::json::parse(file);
  }

  /// What a run drew at a frame, and what is known of it.
  struct Drawn {
    ImageRgb colour;
    ValidityMask valid;
  };
  Drawn drawn(const std::string& out, long index) {
    Monitor monitor;
    ClipOptions whole;
    whole.max_frames = 0;
    whole.resize.mode = ResizePolicy::Mode::none;
    Drawn frame;
    ImageRgb generate;
    EXPECT_TRUE(open_clip(folder_.file(out) + "/colour.mp4", whole, monitor)->read(index, frame.colour));
    EXPECT_TRUE(open_clip(folder_.file(out) + "/generate_mask.mp4", whole, monitor)->read(index, generate));
    frame.valid = ValidityMask(generate.size());
    for (std::size_t i = 0; i < frame.valid.pixels().size(); ++i)
      frame.valid.pixels()[i] = static_cast<std::uint8_t>(generate.pixels()[i].g < 128);
    return frame;
  }

  ThreadPool pool_{2};
  StockScene room_;
  test::TempFolder folder_;
  RunOptions options_;
};

TEST_F(MergedRun, FillsWhatSingleFramesLeaveOpenWithTheTruth) {
  film(13, -3);
  run_into("single", CloudChoice::per_frame);
  const RunSummary merged = run_into("merged", CloudChoice::merged);
  const auto& facts = merged.stages[1].facts["other_frames"];
  EXPECT_GT(facts["filled_share"], 0.02) << facts.dump(1);
  EXPECT_GT(facts["views_drawn_per_frame"], 0.5);
  EXPECT_EQ(facts["views_kept"], 13);
  EXPECT_GT(facts["fill_seconds"], 0);

  Monitor monitor;
  const CameraTrack targets = read_cameras(options_.out + "/cameras_target.json", {}, monitor);
  constexpr long late = 8;
  const SyntheticFrame truth = render(room_.scene, targets.cameras[late], 0, pool_, 2);
  const Drawn before = drawn("single", late), after = drawn("merged", late);
  EXPECT_GT(valid_share(after.valid), valid_share(before.valid) + 0.03);
  ValidityMask added = after.valid;
  for (std::size_t i = 0; i < added.pixels().size(); ++i) added.pixels()[i] &= 1U ^ before.valid.pixels()[i];
  const MetricImage real(truth.colour);
  EXPECT_GT(psnr(MetricImage(after.colour), real, &added), 22);
  EXPECT_GT(psnr(MetricImage(after.colour), real, &after.valid),
            psnr(MetricImage(before.colour), real, &before.valid) - 1);
}

TEST_F(MergedRun, ChoosesByTheNumbersAndSaysWhy) {
  film(9, -3);
  const RunSummary summary = run_into("auto", CloudChoice::automatic);
  const nlohmann::json choices = record()["choices"];
  EXPECT_EQ(choices["cloud"]["choice"], "merged") << choices.dump(1);
  EXPECT_EQ(choices["cloud"]["forced"], false);
  for (const char* name : {"cloud", "layers", "key_stride", "decimate"})
    for (const char* text : {"reason", "saves"}) EXPECT_FALSE(choices[name][text].get<std::string>().empty()) << name;
  const nlohmann::json profile = record()["scene_profile"];
  EXPECT_EQ(profile["motion"], "moving");
  EXPECT_EQ(profile["frames"], 9);
  EXPECT_GT(profile["parallax_px"], profile["parallax_per_frame_px"]);
  EXPECT_GT(profile["disocclusion_share"], 0.02);
  const auto& facts = summary.stages[1].facts;
  const double open = 1 - facts["valid_share"].get<double>() + facts["other_frames"]["filled_share"].get<double>();
  EXPECT_NEAR(profile["disocclusion_share"].get<double>(), open, 0.05) << "the small drawing tells of the large one";
  EXPECT_THAT(summary.report(), HasSubstr("merged cloud"));

  run_into("forced", CloudChoice::per_frame);
  EXPECT_EQ(record()["choices"]["cloud"]["choice"], "per_frame");
  EXPECT_EQ(record()["choices"]["cloud"]["forced"], true);
  EXPECT_THAT(record()["choices"]["cloud"]["reason"].get<std::string>(), HasSubstr("the numbers say otherwise"));
}

TEST_F(MergedRun, ACameraThatStandsSeesNothingNew) {
  film(4, 0);
  const RunSummary summary = run_into("auto", CloudChoice::automatic);
  EXPECT_EQ(record()["choices"]["cloud"]["choice"], "per_frame");
  EXPECT_THAT(summary.stages[1].facts["other_frames"].get<std::string>(), HasSubstr("stands still"));
}

TEST_F(MergedRun, WhatMovesDoesNotJoin) {
  film(6, -4);
  std::filesystem::create_directory(folder_.file("masks"));
  for (int i = 0; i < 6; ++i)
    write_png(folder_.file(fmt::format("masks/{:03}.png", i)), ImageRgb(size, Rgb8{255, 255, 255}));
  options_.foreground = folder_.file("masks");
  const RunSummary left_alone = run_into("auto", CloudChoice::automatic);
  EXPECT_THAT(left_alone.stages[1].facts["other_frames"].get<std::string>(), HasSubstr("move by themselves"));
  const RunSummary forced = run_into("forced", CloudChoice::merged);
  EXPECT_EQ(forced.stages[1].facts["other_frames"]["filled_share"], 0) << "all of the picture moves";
  EXPECT_EQ(forced.stages[1].facts["valid_share"], left_alone.stages[1].facts["valid_share"]);
}

TEST_F(MergedRun, OneFrameHasNoOthers) {
  film(1, 0);
  options_.frames = 3;
  options_.follow_source = false;
  const RunSummary forced = run_into("forced", CloudChoice::merged);
  EXPECT_EQ(forced.stages[1].facts["other_frames"]["filled_share"], 0);
  EXPECT_THAT(record()["choices"]["cloud"]["reason"].get<std::string>(), HasSubstr("nothing to merge"));
}

TEST_F(MergedRun, AThousandFramesKeepAFewViews) {
  constexpr Size tiny{16, 12};
  constexpr int frames = 1000;
  std::filesystem::create_directory(folder_.file("clip"));
  CameraTrack track;
  for (int i = 0; i < frames; ++i) {
    write_png(folder_.file(fmt::format("clip/{:04}.png", i)), ImageRgb(tiny, Rgb8{9, 90, 200}));
    Camera camera{Intrinsics::from_fov_x(1, tiny), {}, tiny};
    camera.world_from_cam.translation.x() = 0.01 * i;
    track.cameras.push_back(camera);
    track.times.push_back(i);
  }
  write_npy<float>(folder_.file("depth.npy"), {frames, tiny.height, tiny.width},
                   std::vector<float>(frames * tiny.pixels(), 3.0F));
  write_cameras(folder_.file("cameras.json"), track, CamerasFormat::uwv);
  options_.video = folder_.file("clip");
  options_.depth = folder_.file("depth.npy");
  options_.cameras = folder_.file("cameras.json");
  options_.no_resize = true;
  options_.max_frames = 0;
  options_.follow_source = true;
  options_.traj = "left";
  options_.contact_sheet = 0;
  options_.renderer = RendererChoice::cpu;
  const RunSummary summary = run_into("many", CloudChoice::merged);
  EXPECT_EQ(summary.stages[1].facts["frames"], frames);
  EXPECT_LE(summary.stages[1].facts["other_frames"]["views_kept"], 24);
}

/// Points of a .ply file, by its header.
long ply_points(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  for (std::string line; std::getline(file, line) && line != "end_header";)
    if (line.starts_with("element vertex ")) return std::stol(line.substr(15));
  return -1;
}

TEST_F(MergedRun, ThinsOutPointsOnlyWhenAskedTo) {
  film(3, -3);
  options_.ply = {1};
  const RunSummary all = run_into("all", CloudChoice::per_frame);
  EXPECT_THAT(all.stages[1].facts["thinned_points"].get<std::string>(), HasSubstr("pixels set the pace"));
  EXPECT_EQ(record()["choices"]["decimate"]["choice"], "off");
  options_.max_error = 0.5;
  const RunSummary few = run_into("few", CloudChoice::per_frame);
  EXPECT_EQ(record()["choices"]["decimate"]["choice"], "on");
  EXPECT_EQ(record()["choices"]["decimate"]["forced"], true);
  const auto& facts = few.stages[1].facts["thinned_points"];
  EXPECT_EQ(facts["points_before"], 3 * size.width * size.height);
  EXPECT_LT(facts["points_after"].get<long>(), facts["points_before"].get<long>() * 2 / 3);
  EXPECT_NEAR(few.stages[1].facts["valid_share"].get<double>(), all.stages[1].facts["valid_share"].get<double>(), 0.02);
  const Drawn a = drawn("all", 2), b = drawn("few", 2);
  ValidityMask both = a.valid;
  intersect(both, b.valid);
  EXPECT_GT(psnr(MetricImage(a.colour), MetricImage(b.colour), &both), 30);
  const long points = ply_points(folder_.file("few") + "/points_00001.ply");
  EXPECT_GT(points, 0);
  EXPECT_LT(points, ply_points(folder_.file("all") + "/points_00001.ply"));

  options_.max_error = 0;
  run_into("none", CloudChoice::per_frame);
  EXPECT_EQ(record()["choices"]["decimate"]["choice"], "off");
  EXPECT_EQ(record()["choices"]["decimate"]["forced"], true);
}

}  // namespace
}  // namespace uwv
