// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/frame_source.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "io/clip_fixtures.h"
#include "io/hostile.h"
#include "support/matchers.h"
#include "uwv/io/image_file.h"

namespace uwv {
namespace {

using namespace test;

TEST(FrameSource, start_stride_and_max_frames_pick_the_right_frames) {
  const TempFolder folder;
  const std::string path = write_numbered_clip(folder.file("a.mp4"), {32, 32}, 50);
  struct Case {
    long start, stride, max_frames, frames;
  };
  for (const Case c : {Case{0, 1, 0, 50}, Case{0, 1, 81, 50}, Case{0, 1, 7, 7}, Case{3, 1, 0, 47}, Case{0, 3, 0, 17},
                       Case{1, 3, 0, 17}, Case{2, 3, 0, 16}, Case{5, 4, 4, 4}, Case{49, 1, 81, 1}, Case{49, 9, 0, 1}}) {
    ClipOptions options = whole_clip_unresized();
    options.start = c.start;
    options.stride = c.stride;
    options.max_frames = c.max_frames;
    Monitor monitor;
    const auto clip = open_clip(path, options, monitor);
    ASSERT_EQ(clip->frames(), c.frames) << "start " << c.start << " stride " << c.stride;
    const std::vector<ImageRgb> frames = read_all(*clip);
    ASSERT_EQ(static_cast<long>(frames.size()), c.frames);
    for (long i = 0; i < c.frames; ++i)
      EXPECT_EQ(number_of(frames[static_cast<std::size_t>(i)]), c.start + i * c.stride) << "frame " << i;
  }
}

TEST(FrameSource, any_order_of_reading_gives_the_same_pixels) {
  const TempFolder folder;
  VideoWriter writer(folder.file("a.mp4"), {64, 48});
  for (int i = 0; i < 40; ++i) writer.write(smooth_picture({64, 48}, i));
  writer.finish();
  const std::vector<ImageRgb> expected = read_all(folder.file("a.mp4"));
  ASSERT_EQ(expected.size(), 40U);
  ClipOptions options = whole_clip_unresized();
  options.threads = 1;
  Monitor monitor;
  const auto clip = open_clip(folder.file("a.mp4"), options, monitor);
  ImageRgb frame;
  for (const long i : {39L, 0L, 0L, 17L, 16L, 38L, 39L, 39L, 2L}) {
    ASSERT_TRUE(clip->read(i, frame));
    EXPECT_IMAGE_NEAR(frame, expected[static_cast<std::size_t>(i)], 0);
  }
  EXPECT_THROW(clip->read(-1, frame), std::invalid_argument);
  EXPECT_THROW(clip->read(40, frame), std::invalid_argument);
}

TEST(FrameSource, frames_arrive_at_the_policys_size) {
  const TempFolder folder;
  const Size size{160, 90};
  VideoWriter writer(folder.file("a.mp4"), size);
  writer.write(smooth_picture(size));
  writer.finish();
  Monitor monitor;
  const auto clip = open_clip(folder.file("a.mp4"), {}, monitor);
  EXPECT_EQ(clip->info().source_size, size);
  EXPECT_EQ(clip->info().size, target_size(size, {}));
  ImageRgb frame;
  ASSERT_TRUE(clip->read(0, frame));
  EXPECT_GT(psnr(frame, resize(smooth_picture(size), clip->info().size)), 38.0);
  EXPECT_EQ(clip->info().fps, 16.0);
  EXPECT_FALSE(clip->info().is_photo) << "a video of one frame is still a video";
  EXPECT_FALSE(clip->info().variable_frame_rate);
  EXPECT_EQ(clip->info().format, "h264 yuv420p bt709 limited");
}

TEST(FrameSource, a_picture_is_a_photo_of_one_frame) {
  const TempFolder folder;
  const ImageRgb picture = smooth_picture({33, 17});
  write_png(folder.file("a.png"), picture);
  Monitor monitor;
  const auto clip = open_clip(folder.file("a.png"), whole_clip_unresized(), monitor);
  EXPECT_TRUE(clip->info().is_photo);
  EXPECT_EQ(clip->frames(), 1);
  EXPECT_EQ(clip->info().fps, 0.0);
  EXPECT_IMAGE_NEAR(read_all(*clip).at(0), picture, 0);
  EXPECT_TRUE(open_clip(folder.path().string(), whole_clip_unresized(), monitor)->info().is_photo);
}

TEST(FrameSource, folder_and_patterns_come_in_natural_order) {
  const TempFolder folder;
  for (int i = 0; i < 12; ++i) write_png(folder.file(fmt::format("frame{}.png", i)), numbered_picture({8, 8}, i));
  folder.write("readme.txt", "not a frame");
  for (const std::string& path : {folder.path().string(), folder.file("frame%d.png"), folder.file("frame*.png")}) {
    const std::vector<ImageRgb> frames = read_all(path);
    ASSERT_EQ(frames.size(), 12U) << path;
    for (int i = 0; i < 12; ++i) EXPECT_EQ(number_of(frames[static_cast<std::size_t>(i)]), i) << path;
  }
  ClipOptions options = whole_clip_unresized();
  options.start = 1;
  options.stride = 5;
  const std::vector<ImageRgb> some = read_all(folder.path().string(), options);
  ASSERT_EQ(some.size(), 3U);
  EXPECT_EQ(number_of(some[2]), 11);
}

TEST(FrameSource, pictures_of_different_sizes_are_refused_by_name) {
  const TempFolder folder;
  write_png(folder.file("1.png"), ImageRgb(8, 8));
  write_png(folder.file("2.png"), ImageRgb(9, 8));
  expect_error(ErrorCode::size_mismatch, folder.file("2.png"), [&] { read_all(folder.path().string()); });
}

TEST(FrameSource, a_file_named_like_a_pattern_is_a_file) {
  const TempFolder folder;
  write_png(folder.file("a%d*.png"), ImageRgb(8, 8));
  EXPECT_EQ(read_all(folder.file("a%d*.png")).size(), 1U);
}

TEST(FrameSource, start_behind_the_end_and_nonsense_options) {
  const TempFolder folder;
  const std::string path = write_numbered_clip(folder.file("a.mp4"), {16, 16}, 5);
  Monitor monitor;
  ClipOptions options = whole_clip_unresized();
  options.start = 5;
  expect_error(ErrorCode::value_invalid, path, [&] { open_clip(path, options, monitor); });
  for (const auto spoil : {+[](ClipOptions& o) { o.start = -1; }, +[](ClipOptions& o) { o.stride = 0; },
                           +[](ClipOptions& o) { o.max_frames = -1; }, +[](ClipOptions& o) { o.threads = -1; }}) {
    ClipOptions bad;
    spoil(bad);
    EXPECT_THROW(open_clip(path, bad, monitor), std::invalid_argument);
  }
}

TEST(FrameSource, counting_a_long_file_can_be_stopped) {
  class Impatient : public Monitor {
    bool progress(std::string_view, long, long) override { return false; }
  };
  const TempFolder folder;
  VideoWriter writer(folder.file("a.mp4"), {16, 16});
  for (int i = 0; i < 1100; ++i) writer.write(numbered_picture({16, 16}, i % 50));
  writer.finish();
  Impatient impatient;
  try {
    open_clip(folder.file("a.mp4"), whole_clip_unresized(), impatient);
    FAIL() << "not stopped";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::cancelled);
  }
}

}  // namespace
}  // namespace uwv
