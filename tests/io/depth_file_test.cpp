// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/depth_file.h"

#include <gtest/gtest.h>

#include <cstring>
#include <opencv2/imgcodecs.hpp>

#include "io/depth_samples.h"
#include "io/hostile.h"
#include "uwv/io/npy.h"

namespace uwv {
namespace {

using test::expect_depth_near;
using test::expect_error;
using test::nasty_depth;
using test::nasty_depth_as_read;
using test::ramp_depth;
using test::TempFolder;

class FloatDepthFile : public testing::TestWithParam<const char*> {};

TEST_P(FloatDepthFile, RoundTripsExactly) {
  const TempFolder folder;
  const std::string path = folder.file(std::string("d") + GetParam());
  for (const Size size : {Size{1, 1}, Size{7, 1}, Size{1, 5}, Size{31, 17}}) {
    write_depth_file(path, ramp_depth(size));
    expect_depth_near(read_depth_file(path), ramp_depth(size), 0);
  }
}

TEST_P(FloatDepthFile, MakesWhatIsNoDepthInvalid) {
  const TempFolder folder;
  const std::string path = folder.file(std::string("d") + GetParam());
  write_depth_file(path, nasty_depth());
  EXPECT_EQ(read_depth_file(path), nasty_depth_as_read());
}

TEST_P(FloatDepthFile, AppliesTheScaleBothWays) {
  const TempFolder folder;
  const std::string path = folder.file(std::string("d") + GetParam());
  write_depth_file(path, ramp_depth({4, 3}), {0.25, ""});
  expect_depth_near(read_depth_file(path, {0.25, ""}), ramp_depth({4, 3}), 0);
  EXPECT_EQ(read_depth_file(path)(0, 0), 4.F);
}

TEST_P(FloatDepthFile, SurvivesTruncationAndRandomDamage) {
  const TempFolder folder;
  const std::string name = std::string("d") + GetParam();
  write_depth_file(folder.file(name), ramp_depth({5, 3}));
  const auto read = [](const std::string& path) { (void)read_depth_file(path); };
  EXPECT_EQ(test::try_truncations(folder.read(name), name, read), 0);
  test::try_byte_flips(folder.read(name), name, read, 500);
}

INSTANTIATE_TEST_SUITE_P(Formats, FloatDepthFile, testing::Values(".npy", ".exr", ".pfm"),
                         [](const auto& format) { return std::string(format.param + 1); });

TEST(DepthFile, PngRoundsToItsScale) {
  const TempFolder folder;
  const std::string path = folder.file("d.png");
  EXPECT_EQ(write_depth_file(path, ramp_depth({9, 4})).too_far, 0U);
  expect_depth_near(read_depth_file(path), ramp_depth({9, 4}), 1e-6);
  write_depth_file(path, ramp_depth({9, 4}), {0.01, ""});
  expect_depth_near(read_depth_file(path, {0.01, ""}), ramp_depth({9, 4}), 0.005 + 1e-6);
}

TEST(DepthFile, PngCountsWhatItCannotHold) {
  const TempFolder folder;
  const std::string path = folder.file("d.png");
  const DepthLoss loss = write_depth_file(path, nasty_depth(), {1e-3, ""});
  EXPECT_EQ(loss.too_far, 1U);   // 1e9
  EXPECT_EQ(loss.too_near, 1U);  // 1e-6
  DepthMap wanted(5, 2);
  wanted(4, 1) = 2.5F;
  expect_depth_near(read_depth_file(path), wanted, 1e-6);
  DepthMap edge(2, 1);
  edge(0, 0) = 65.535F;
  edge(1, 0) = 65.5356F;
  EXPECT_EQ(write_depth_file(path, edge).too_far, 1U);
  EXPECT_NEAR(read_depth_file(path)(0, 0), 65.535F, 1e-4);
  EXPECT_EQ(read_depth_file(path)(1, 0), 0.F);
}

TEST(DepthFile, RefusesPngsThatHoldNoDepth) {
  const TempFolder folder;
  const std::string path = folder.file("d.png");
  cv::imwrite(path, cv::Mat(2, 3, CV_8UC1, cv::Scalar(7)));
  expect_error(ErrorCode::format_unknown, path, [&] { (void)read_depth_file(path); });
  cv::imwrite(path, cv::Mat(2, 3, CV_16UC3, cv::Scalar(7, 8, 9)));
  expect_error(ErrorCode::format_unknown, path, [&] { (void)read_depth_file(path); });
}

TEST(DepthFile, PngSurvivesTruncationAndRandomDamage) {
  const TempFolder folder;
  write_depth_file(folder.file("d.png"), ramp_depth({5, 3}));
  const auto read = [](const std::string& path) { (void)read_depth_file(path); };
  const std::string bytes = folder.read("d.png");
  EXPECT_EQ(test::try_truncations(bytes.substr(0, bytes.size() - 12), "d.png", read),
            0);  // without the empty end chunk
  test::try_byte_flips(bytes, "d.png", read, 500);
}

TEST(DepthFile, RefusesPicturesOfAbsurdSize) {
  const TempFolder folder;
  write_depth_file(folder.file("d.png"), ramp_depth({5, 3}));
  std::string png = folder.read("d.png");
  png.replace(16, 8, std::string("\0\0\xFF\xFF\0\0\x0F\xFF", 8));  // 65535x4095
  const std::string png_path = folder.write("lie.png", png);
  expect_error(ErrorCode::file_damaged, png_path, [&] { (void)read_depth_file(png_path); });
  for (const std::string header :
       {"Pf\n1000000 1000000\n-1\n", "Pf\n60000 4000\n-1\n", "Pf\n-3 3\n-1\n", "Pf\n0 3\n-1\n", "Pf\n3 3\n0\n",
        "Pf\n3 3\nnan\n", "Pf\n3", "Pf\n18446744073709551615 2\n-1\n"}) {
    SCOPED_TRACE(header);
    const std::string path = folder.write("lie.pfm", header + std::string(8, 'x'));
    expect_error(ErrorCode::file_damaged, path, [&] { (void)read_depth_file(path); });
  }
}

TEST(DepthFile, RefusesExrsOfAbsurdSize) {
  const TempFolder folder;
  write_depth_file(folder.file("d.exr"), ramp_depth({5, 3}));
  for (const std::int32_t last : {16383, 100000, std::numeric_limits<std::int32_t>::max(), -1}) {
    SCOPED_TRACE(last);
    std::string exr = folder.read("d.exr");
    for (const std::string window : {"dataWindow", "displayWindow"}) {
      const std::size_t at = exr.find(window) + window.size() + std::string("?box2i?size").size();
      for (const std::size_t max : {at + 8, at + 12}) std::memcpy(&exr[max], &last, sizeof last);
    }
    const std::string path = folder.write("lie.exr", exr);
    expect_error(ErrorCode::file_damaged, path, [&] { (void)read_depth_file(path); });
  }
}

TEST(DepthFile, ReadsBigEndianPfm) {
  const TempFolder folder;
  // two rows of one value, bottom row first: 2 below 1
  const std::string path = folder.write("d.pfm", "Pf 1 2 1.0\n" + std::string("\x40\0\0\0\x3F\x80\0\0", 8));
  const DepthMap depth = read_depth_file(path);
  EXPECT_EQ(depth(0, 0), 1.F);
  EXPECT_EQ(depth(0, 1), 2.F);
  const std::string colour = folder.write("c.pfm", "PF 1 1 -1.0\n" + std::string(12, '\0'));
  expect_error(ErrorCode::format_unknown, colour, [&] { (void)read_depth_file(colour); });
}

TEST(DepthFile, ReadsOneFrameFromArrays) {
  const TempFolder folder;
  const DepthMap depth = ramp_depth({3, 2});
  for (const std::vector<std::size_t>& shape :
       std::vector<std::vector<std::size_t>>{{2, 3}, {1, 2, 3}, {1, 1, 2, 3}, {1, 2, 3, 1}}) {
    write_npy<float>(folder.file("d.npy"), shape, depth.pixels());
    EXPECT_EQ(read_depth_file(folder.file("d.npy")), depth);
  }
  write_npy<float>(folder.file("two.npy"), {2, 1, 3}, depth.pixels());
  expect_error(ErrorCode::value_invalid, folder.file("two.npy"),
               [&] { (void)read_depth_file(folder.file("two.npy")); });
}

TEST(DepthFile, RefusesOtherFiles) {
  const TempFolder folder;
  const std::string text = folder.write("d.npy", "this is only text");
  expect_error(ErrorCode::format_unknown, text, [&] { (void)read_depth_file(text); });
  const std::string empty = folder.write("e.npy", "");
  expect_error(ErrorCode::file_damaged, empty, [&] { (void)read_depth_file(empty); });
  expect_error(ErrorCode::file_not_found, folder.file("none"), [&] { (void)read_depth_file(folder.file("none")); });
  expect_error(ErrorCode::format_unknown, folder.file("d.jpg"), [&] {
    write_depth_file(folder.file("d.jpg"), ramp_depth({2, 2}));
  });
  expect_error(ErrorCode::output_failed, folder.file("none/d.exr"), [&] {
    write_depth_file(folder.file("none/d.exr"), ramp_depth({2, 2}));
  });
  EXPECT_THROW((void)read_depth_file(text, {-1, ""}), std::invalid_argument);
}

}  // namespace
}  // namespace uwv
