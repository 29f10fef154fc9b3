// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/depth_source.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "io/depth_samples.h"
#include "io/hostile.h"
#include "support/recording_monitor.h"
#include "uwv/io/depth_file.h"
#include "uwv/io/npy.h"

namespace uwv {
namespace {

using test::expect_depth_near;
using test::expect_error;
using test::ramp_depth;
using test::RecordingMonitor;
using test::TempFolder;

constexpr Size small{4, 3};

/// Frame i is ramp_depth(small, 100 i).
std::vector<float> clip_values(int frames) {
  std::vector<float> values;
  for (int i = 0; i < frames; ++i) {
    const DepthMap depth = ramp_depth(small, 100.F * static_cast<float>(i));
    values.insert(values.end(), depth.pixels().begin(), depth.pixels().end());
  }
  return values;
}

void expect_clip(const std::string& path, const DepthOptions& options, const std::vector<int>& wanted_frames) {
  RecordingMonitor monitor;
  const auto source = open_depth(path, options, monitor);
  ASSERT_EQ(source->frames(), static_cast<long>(wanted_frames.size()));
  EXPECT_EQ(source->size(), small);
  DepthMap depth;
  for (std::size_t k = wanted_frames.size(); k-- > 0;) {  // backwards, the harder way
    ASSERT_TRUE(source->read(static_cast<long>(k), depth));
    expect_depth_near(depth, ramp_depth(small, 100.F * static_cast<float>(wanted_frames[k])), 0);
  }
  EXPECT_FALSE(source->read(source->frames(), depth));
}

TEST(DepthSource, ReadsEveryArrayShape) {
  const TempFolder folder;
  const std::string path = folder.file("d.npy");
  write_npy<float>(path, {3, 4}, clip_values(1));
  expect_clip(path, {}, {0});
  for (const std::vector<std::size_t>& shape :
       std::vector<std::vector<std::size_t>>{{5, 3, 4}, {5, 1, 3, 4}, {5, 3, 4, 1}}) {
    write_npy<float>(path, shape, clip_values(5));
    expect_clip(path, {}, {0, 1, 2, 3, 4});
  }
}

TEST(DepthSource, PicksFramesAsTheVideoDoes) {
  const TempFolder folder;
  const std::string path = folder.file("d.npy");
  write_npy<float>(path, {7, 3, 4}, clip_values(7));
  DepthOptions options;
  options.start = 1;
  options.stride = 2;
  expect_clip(path, options, {1, 3, 5});
  options.max_frames = 2;
  expect_clip(path, options, {1, 3});
  options.start = 6;
  expect_clip(path, options, {6});
  options.start = 7;
  RecordingMonitor monitor;
  expect_error(ErrorCode::value_invalid, path, [&] { open_depth(path, options, monitor); });
  options.stride = 0;
  EXPECT_THROW(open_depth(path, options, monitor), std::invalid_argument);
}

TEST(DepthSource, FindsTheUsualKeys) {
  const TempFolder folder;
  const std::string path = folder.file("d.npz");
  for (const char* key : {"dep", "depth", "depths", "arr_0", "anything"}) {
    for (const int level : {0, 6}) {
      NpzWriter writer(path);
      if (std::string(key) != "anything") writer.add<float>("other", {1}, std::vector<float>{1});
      const std::vector<float> values = clip_values(3);
      writer.add(key, DType::f32, {3, 3, 4}, std::as_bytes(std::span(values)), level);
      writer.finish();
      expect_clip(path, {}, {0, 1, 2});
    }
  }
  DepthOptions options;
  options.key = "missing";
  RecordingMonitor monitor;
  expect_error(ErrorCode::value_invalid, path, [&] { open_depth(path, options, monitor); });
}

TEST(DepthSource, PrefersTheOfficialKey) {
  const TempFolder folder;
  NpzWriter writer(folder.file("d.npz"));
  writer.add<float>("arr_0", {1, 1}, std::vector<float>{1});
  writer.add<float>("dep", {1, 1}, std::vector<float>{2});
  writer.finish();
  RecordingMonitor monitor;
  DepthMap depth;
  open_depth(folder.file("d.npz"), {}, monitor)->read(0, depth);
  EXPECT_EQ(depth(0, 0), 2.F);
  DepthOptions options;
  options.key = "arr_0";
  open_depth(folder.file("d.npz"), options, monitor)->read(0, depth);
  EXPECT_EQ(depth(0, 0), 1.F);
}

TEST(DepthSource, ReadsFoldersInNaturalOrder) {
  const TempFolder folder;
  for (int i = 0; i < 12; ++i)
    write_depth_file(folder.file("d" + std::to_string(i) + ".exr"), ramp_depth(small, 100.F * static_cast<float>(i)));
  folder.write("notes.txt", "not a depth");
  const std::vector<int> all = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
  expect_clip(folder.path(), {}, all);
  expect_clip(folder.file("d%d.exr"), {}, all);
  expect_clip(folder.file("*.exr"), {}, all);
  expect_clip(folder.file("d2.exr"), {}, {2});
  write_depth_file(folder.file("d0.pfm"), ramp_depth(small));
  RecordingMonitor monitor;
  expect_error(ErrorCode::format_unknown, folder.path(), [&] { open_depth(folder.path(), {}, monitor); });
  write_depth_file(folder.file("d3.exr"), ramp_depth({2, 2}));
  const auto source = open_depth(folder.file("d%d.exr"), {}, monitor);
  DepthMap depth;
  expect_error(ErrorCode::size_mismatch, folder.file("d3.exr"), [&] { source->read(3, depth); });
}

TEST(DepthSource, WarnsOfWholeNumbersAndSlowOrder) {
  const TempFolder folder;
  RecordingMonitor monitor;
  write_npy<std::uint16_t>(folder.file("mm.npy"), {1, 2}, std::vector<std::uint16_t>{1500, 0});
  DepthMap depth;
  open_depth(folder.file("mm.npy"), {}, monitor)->read(0, depth);
  EXPECT_EQ(depth(0, 0), 1500.F);
  EXPECT_EQ(monitor.warnings.size(), 1U);
  DepthOptions millimetres;
  millimetres.scale = 0.001;
  open_depth(folder.file("mm.npy"), millimetres, monitor)->read(0, depth);
  EXPECT_FLOAT_EQ(depth(0, 0), 1.5F);
  EXPECT_EQ(monitor.warnings.size(), 1U);
}

TEST(DepthSource, RefusesWhatIsNoDepth) {
  const TempFolder folder;
  RecordingMonitor monitor;
  const auto refused = [&](ErrorCode code, const std::string& path) {
    expect_error(code, path, [&] { open_depth(path, {}, monitor); });
  };
  for (const std::vector<std::size_t>& shape :
       std::vector<std::vector<std::size_t>>{{}, {12}, {0, 3, 4}, {2, 2, 3, 1, 1}, {1, 3, 2, 2}}) {
    const std::size_t n = shape.empty() ? 1 : shape[0] == 0 ? 0 : 12;
    write_npy<float>(folder.file("d.npy"), shape, std::vector<float>(n, 1.F));
    refused(ErrorCode::value_invalid, folder.file("d.npy"));
  }
  write_npy<float>(folder.file("thin.npy"), {100000, 1}, std::vector<float>(100000, 1.F));
  refused(ErrorCode::file_damaged, folder.file("thin.npy"));
  refused(ErrorCode::file_not_found, folder.file("none.npy"));
  refused(ErrorCode::file_not_found, folder.file("none%05d.png"));
  const TempFolder bare;
  bare.write("readme.txt", "x");
  refused(ErrorCode::format_unknown, bare.path());
}

TEST(ResizeDepth, KeepsConstantsAndSize) {
  const DepthMap flat(5, 4, 3.F);
  for (const Size size : {Size{1, 1}, Size{3, 9}, Size{10, 8}, Size{50, 40}})
    expect_depth_near(resize_depth(flat, size), DepthMap(size, 3.F), 0);
  EXPECT_EQ(resize_depth(ramp_depth({5, 4}), {5, 4}), ramp_depth({5, 4}));
  EXPECT_THROW(resize_depth(flat, {0, 4}), std::invalid_argument);
}

TEST(ResizeDepth, IsExactOnTiltedPlanes) {
  // 1/z is affine in the pixel's centre, here in shares of the picture.
  const auto plane = [](Size size) {
    DepthMap depth(size);
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x) {
        const double u = (x + 0.5) / size.width, v = (y + 0.5) / size.height;
        depth(x, y) = static_cast<float>(1 / (0.5 + 0.3 * u - 0.2 * v));
      }
    return depth;
  };
  const DepthMap got = resize_depth(plane({40, 30}), {100, 90}), wanted = plane({100, 90});
  for (int y = 2; y < 88; ++y)  // borders repeat the outermost pixel
    for (int x = 2; x < 98; ++x) ASSERT_NEAR(got(x, y), wanted(x, y), 2e-6) << "(" << x << ", " << y << ")";
}

TEST(ResizeDepth, NeverInventsDepthsBetweenSurfaces) {
  DepthMap depth(8, 8, 10.F);
  for (int y = 2; y < 6; ++y)
    for (int x = 2; x < 6; ++x) depth(x, y) = 1.F;
  depth(0, 0) = 0;
  for (const Size size : {Size{3, 3}, Size{13, 5}, Size{31, 33}}) {
    const DepthMap resized = resize_depth(depth, size);
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x)
        EXPECT_TRUE(resized(x, y) == 1.F || resized(x, y) == 10.F || resized(x, y) == 0.F)
            << "(" << x << ", " << y << "): " << resized(x, y);
  }
}

}  // namespace
}  // namespace uwv
