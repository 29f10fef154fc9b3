// SPDX-License-Identifier: Apache-2.0
// The run as a library call: the monitor's part, and depth formats. tests/apps has the rest, from outside.
#include "uwv/pipeline/run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "support/temp_folder.h"
#include "uwv/io/depth_source.h"
#include "uwv/io/image_file.h"
#include "uwv/io/npy.h"
#include "uwv/pipeline/compare.h"

namespace uwv {
namespace {

namespace fs = std::filesystem;

/// Counts steps and stops at one of them.
class CountingMonitor : public Monitor {
 public:
  explicit CountingMonitor(long stop_at = -1) : stop_at_(stop_at) {}
  bool progress(std::string_view stage, long done, long /*total*/) override {
    stages.emplace_back(stage);
    last_done = done;
    return ++steps != stop_at_;
  }
  void warn(const std::string& sentence) override { warnings.push_back(sentence); }

  std::vector<std::string> stages, warnings;
  long steps = 0, last_done = 0;

 private:
  long stop_at_;
};

class RunTest : public ::testing::Test {
 protected:
  RunTest() {
    ImageRgb picture(40, 30);
    DepthMap depth(40, 30, 3.0F);
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 40; ++x) {
        const bool near = x > 12 && x < 24 && y > 8 && y < 20;
        picture(x, y) = near ? Rgb8{200, 30, 30} : Rgb8{40, static_cast<std::uint8_t>(6 * x), 90};
        if (near) depth(x, y) = 1.5F;
      }
    write_png(folder_.file("photo.png"), picture);
    write_npy<float>(folder_.file("depth.npy"), {30, 40}, depth.pixels());
    options_.video = folder_.file("photo.png");
    options_.depth = folder_.file("depth.npy");
    options_.out = folder_.file("out");
    options_.fov = 60;
    options_.no_resize = true;
    options_.frames = 6;
    options_.traj = "right";
    options_.renderer = RendererChoice::cpu;
  }

  test::TempFolder folder_;
  RunOptions options_;
};

TEST_F(RunTest, SummaryTellsWhatWasDone) {
  CountingMonitor monitor;
  const RunSummary summary = run(options_, monitor);
  ASSERT_EQ(summary.stages.size(), 5U);
  EXPECT_EQ(summary.stages[0].status, StageSummary::Status::skipped);
  EXPECT_EQ(summary.stages[0].reason, "--depth is given");
  EXPECT_EQ(summary.stages[1].facts["frames"], 6);
  EXPECT_EQ(summary.stages[2].status, StageSummary::Status::skipped);
  EXPECT_EQ(summary.stages[2].reason, "--complete none");
  for (const std::string& file : summary.stages[1].files) EXPECT_TRUE(fs::exists(fs::path(summary.out) / file)) << file;
  EXPECT_TRUE(monitor.warnings.empty()) << monitor.warnings.front();
  EXPECT_THAT(monitor.stages, ::testing::Contains("conditioning"));
  EXPECT_THAT(summary.report(), ::testing::HasSubstr("skipped (--complete none)"));
}

TEST_F(RunTest, StopsAtWhateverStepTheMonitorSays) {
  CountingMonitor all;
  run(options_, all);
  fs::remove_all(options_.out);
  for (long stop = 1; stop <= all.steps; ++stop) {
    CountingMonitor monitor(stop);
    try {
      run(options_, monitor);
      ADD_FAILURE() << "step " << stop << " did not stop the run";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::cancelled) << error.what();
    }
    const bool conditioned = fs::exists(options_.out + "/colour.mp4");
    EXPECT_EQ(fs::exists(options_.out), conditioned) << "stopped at step " << stop;
    if (conditioned) {
      for (const auto& entry : fs::directory_iterator(options_.out))
        EXPECT_EQ(entry.path().filename().string().find("partial"), std::string::npos) << entry.path();
    }
    fs::remove_all(options_.out);
  }
}

TEST_F(RunTest, DepthFormatsAgree) {
  Monitor monitor;
  DepthMap reference, other;
  options_.out = folder_.file("npz");
  run(options_, monitor);
  const auto npz = open_depth(folder_.file("npz/depth.npz"), {}, monitor);
  for (const auto& [format, tolerance] :
       std::vector<std::pair<DepthOutput, float>>{{DepthOutput::exr, 0.0F}, {DepthOutput::png16, 5e-4F}}) {
    options_.out = folder_.file(tolerance == 0 ? "exr" : "png");
    options_.depth_format = format;
    run(options_, monitor);
    const auto source = open_depth(options_.out + "/depth", {}, monitor);
    ASSERT_EQ(source->frames(), 6);
    for (long i = 0; i < 6; ++i) {
      ASSERT_TRUE(npz->read(i, reference) && source->read(i, other));
      for (std::size_t p = 0; p < reference.pixels().size(); ++p)
        ASSERT_NEAR(other.pixels()[p], reference.pixels()[p], tolerance) << options_.out << " frame " << i;
    }
  }
}

TEST_F(RunTest, WithoutDepthFileNoneIsWritten) {
  Monitor monitor;
  options_.depth_format = DepthOutput::none;
  run(options_, monitor);
  EXPECT_FALSE(fs::exists(options_.out + "/depth.npz"));
}

TEST_F(RunTest, OptionsOutOfRangeAreTheCallersMistake) {
  Monitor monitor;
  options_.crf = 99;
  EXPECT_THROW(run(options_, monitor), std::invalid_argument);
}

TEST_F(RunTest, ImportedNormalsReplaceThoseOfTheDepth) {
  Monitor monitor;
  // Normals turned by more than 20 degrees from every viewing direction: alpha = 10 degrees lets none pass.
  std::vector<float> turned(30 * 40 * 3, 0.0F);
  for (std::size_t i = 0; i < turned.size(); i += 3) turned[i] = 0.8F, turned[i + 2] = -0.6F;
  write_npy<float>(folder_.file("normals.npy"), {30, 40, 3}, turned);
  options_.traj = "still";
  options_.keep_source = false;
  const double with_depth = run(options_, monitor).stages[1].facts["valid_share"];
  options_.normals = folder_.file("normals.npy");
  options_.alpha = 10;
  const double with_normals = run(options_, monitor).stages[1].facts["valid_share"];
  EXPECT_GT(with_depth, 0.3);
  EXPECT_EQ(with_normals, 0);
}

TEST_F(RunTest, ComparisonOfAClipWithItselfIsPerfect) {
  Monitor monitor;
  const ClipComparison same = compare_clips({options_.video, options_.video, ""}, monitor);
  EXPECT_EQ(same.equal_frames(), 1);
  EXPECT_TRUE(std::isinf(same.mean_psnr())) << same.report();
  EXPECT_DOUBLE_EQ(same.mean_ssim(), 1);
  EXPECT_DOUBLE_EQ(same.mean_valid_share(), 1);
}

}  // namespace
}  // namespace uwv
