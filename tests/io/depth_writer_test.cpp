// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/depth_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "io/depth_samples.h"
#include "io/hostile.h"
#include "support/recording_monitor.h"
#include "uwv/io/depth_source.h"

namespace uwv {
namespace {

namespace fs = std::filesystem;
using test::expect_depth_near;
using test::expect_error;
using test::ramp_depth;
using test::RecordingMonitor;
using test::TempFolder;

constexpr Size small{6, 4};

class DepthWriterTest : public testing::TestWithParam<DepthFormat> {
 protected:
  std::unique_ptr<DepthWriter> writer(long frames = 0) {
    DepthWriterOptions options;
    options.format = GetParam();
    return make_depth_writer(path, options, small, frames, monitor);
  }
  TempFolder folder;
  RecordingMonitor monitor;
  std::string path = folder.file("depth.out");
};

TEST_P(DepthWriterTest, WhatIsWrittenIsRead) {
  auto out = writer(3);
  for (int i = 0; i < 3; ++i) out->write(ramp_depth(small, static_cast<float>(i)));
  EXPECT_FALSE(fs::exists(path));
  out->finish();
  EXPECT_TRUE(monitor.warnings.empty());
  const auto in = open_depth(path, {}, monitor);
  ASSERT_EQ(in->frames(), 3);
  DepthMap depth;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(in->read(i, depth));
    expect_depth_near(depth, ramp_depth(small, static_cast<float>(i)), 1e-6);
  }
}

TEST_P(DepthWriterTest, LeavesNothingBehindUnlessFinished) {
  writer()->write(ramp_depth(small));
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST_P(DepthWriterTest, ReplacesItsOwnEarlierOutput) {
  for (const int frames : {5, 2}) {
    auto out = writer();
    for (int i = 0; i < frames; ++i) out->write(ramp_depth(small));
    out->finish();
    EXPECT_EQ(open_depth(path, {}, monitor)->frames(), frames);
  }
}

TEST_P(DepthWriterTest, HoldsTheCallerToSizeAndCount) {
  auto out = writer(2);
  EXPECT_THROW(out->write(ramp_depth({3, 3})), std::invalid_argument);
  out->write(ramp_depth(small));
  EXPECT_THROW(out->finish(), std::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(Formats, DepthWriterTest,
                         testing::Values(DepthFormat::npz, DepthFormat::png16, DepthFormat::exr),
                         [](const auto& format) { return std::string(to_string(format.param)); });

TEST(DepthWriter, StatesTheScaleBesidePngs) {
  const TempFolder folder;
  RecordingMonitor monitor;
  DepthWriterOptions options;
  options.format = DepthFormat::png16;
  options.png_scale = 0.125;
  const auto out = make_depth_writer(folder.file("d"), options, small, 0, monitor);
  out->write(ramp_depth(small));
  out->finish();
  DepthMap depth;
  open_depth(folder.file("d"), {}, monitor)->read(0, depth);
  expect_depth_near(depth, ramp_depth(small), 0);
  folder.write("d/depth.json", R"({"uwv_depth":1,"scale":-1})");
  expect_error(ErrorCode::value_invalid, folder.file("d/depth.json"),
               [&] { open_depth(folder.file("d"), {}, monitor); });
}

TEST(DepthWriter, WarnsOfWhatPngCannotHold) {
  const TempFolder folder;
  RecordingMonitor monitor;
  DepthWriterOptions options;
  options.format = DepthFormat::png16;
  const auto out = make_depth_writer(folder.file("d"), options, {5, 2}, 0, monitor);
  out->write(test::nasty_depth());
  out->finish();
  ASSERT_EQ(monitor.warnings.size(), 2U);
  EXPECT_THAT(monitor.warnings[0], testing::HasSubstr("1 depths beyond 65.535"));
  EXPECT_THAT(monitor.warnings[1], testing::HasSubstr("1 depths below 0.0005"));
}

TEST(DepthWriter, DoesNotReplaceOtherPeoplesFolders) {
  const TempFolder folder;
  RecordingMonitor monitor;
  fs::create_directory(folder.file("d"));
  folder.write("d/holiday.png", "precious");
  DepthWriterOptions options;
  options.format = DepthFormat::exr;
  expect_error(ErrorCode::output_failed, folder.file("d"),
               [&] { make_depth_writer(folder.file("d"), options, small, 0, monitor); });
  EXPECT_EQ(folder.read("d/holiday.png"), "precious");
  folder.write("file", "x");
  expect_error(ErrorCode::output_failed, folder.file("file"),
               [&] { make_depth_writer(folder.file("file"), options, small, 0, monitor); });
}

TEST(DepthWriter, KnowsItsFormatsByName) {
  for (const DepthFormat format : {DepthFormat::npz, DepthFormat::png16, DepthFormat::exr})
    EXPECT_EQ(depth_format_named(to_string(format)), format);
  EXPECT_THROW((void)depth_format_named("jpg"), std::invalid_argument);
}

}  // namespace
}  // namespace uwv
