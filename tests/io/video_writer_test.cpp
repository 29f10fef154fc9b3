// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/video_writer.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/videoio.hpp>
#include <random>

#include "io/clip_fixtures.h"
#include "io/hostile.h"
#include "support/matchers.h"

namespace uwv {
namespace {

using namespace test;

constexpr Size sizes[] = {{16, 16}, {64, 48}, {832, 480}, {33, 17}, {1, 1}, {3, 2}};

TEST(VideoWriter, colour_survives_the_round_trip) {
  const TempFolder folder;
  for (const Size size : sizes) {
    SCOPED_TRACE(fmt::format("{}x{}", size.width, size.height));
    VideoWriter writer(folder.file("a.mp4"), size);
    for (int i = 0; i < 5; ++i) writer.write(smooth_picture(size, i));
    writer.finish();
    const std::vector<ImageRgb> back = read_all(folder.file("a.mp4"));
    ASSERT_EQ(back.size(), 5U);
    for (int i = 0; i < 5; ++i) {
      const ImageRgb& frame = back[static_cast<std::size_t>(i)];
      ASSERT_EQ(frame.size(), size);
      EXPECT_GT(psnr(frame, smooth_picture(size, i)), 40.0) << "frame " << i;
      // Over a handful of pixels, rounding to whole YCbCr codes alone is up to a level.
      const double most = size.pixels() < 16 ? 1.5 : 1.0;
      for (const double shift : mean_shift(frame, smooth_picture(size, i))) EXPECT_LT(std::abs(shift), most);
    }
  }
}

template <class Mask>
Mask random_mask(Size size, unsigned seed) {
  std::mt19937 random(seed);
  Mask mask(size);
  for (auto& v : mask.pixels()) v = random() % 2 == 0;
  return mask;
}

// How many levels of any channel are not exactly what the mask says.
template <class Mask>
std::size_t wrong_pixels(const ImageRgb& picture, const Mask& mask) {
  std::size_t wrong = picture.size() == mask.size() ? 0 : 1000000;
  for (std::size_t i = 0; wrong < 1000000 && i < mask.pixels().size(); ++i) {
    const auto level = static_cast<std::uint8_t>(mask.pixels()[i] != 0 ? 255 : 0);
    wrong += picture.pixels()[i] != Rgb8{level, level, level};
  }
  return wrong;
}

ImageRgb from_bgr(const cv::Mat& bgr) {
  ImageRgb picture(bgr.cols, bgr.rows);
  for (int y = 0; y < bgr.rows; ++y)
    for (int x = 0; x < bgr.cols; ++x) {
      const cv::Vec3b v = bgr.at<cv::Vec3b>(y, x);
      picture(x, y) = {v[2], v[1], v[0]};
    }
  return picture;
}

TEST(VideoWriter, masks_come_back_exactly_from_every_reader) {
  const TempFolder folder;
  for (const Size size : sizes) {
    SCOPED_TRACE(fmt::format("{}x{}", size.width, size.height));
    std::vector<GenerateMask> masks;
    VideoWriter writer(folder.file("generate_mask.mp4"), size, VideoWriterOptions::for_masks());
    for (unsigned i = 0; i < 4; ++i) writer.write(masks.emplace_back(random_mask<GenerateMask>(size, i)));
    writer.finish();
    const std::vector<ImageRgb> ours = read_all(folder.file("generate_mask.mp4"));
    ASSERT_EQ(ours.size(), masks.size());
    cv::VideoCapture capture(folder.file("generate_mask.mp4"), cv::CAP_FFMPEG);
    for (std::size_t i = 0; i < masks.size(); ++i) {
      EXPECT_EQ(wrong_pixels(ours[i], masks[i]), 0U) << "our reader, frame " << i;
      cv::Mat bgr;
      ASSERT_TRUE(capture.read(bgr));
      EXPECT_EQ(wrong_pixels(from_bgr(bgr), masks[i]), 0U) << "cv::VideoCapture, frame " << i;
    }
  }
}

TEST(VideoWriter, masks_come_back_exactly_from_the_ffmpeg_program) {
  if (!have_ffmpeg()) GTEST_SKIP() << "no ffmpeg program";
  const TempFolder folder;
  const Size size{64, 48};
  const auto mask = random_mask<ValidityMask>(size, 1);
  VideoWriter writer(folder.file("validity.mp4"), size, VideoWriterOptions::for_masks());
  writer.write(mask);
  writer.finish();
  ASSERT_TRUE(ffmpeg("-i " + folder.file("validity.mp4") + " -f rawvideo -pix_fmt gray " + folder.file("raw")));
  const std::string grey = folder.read("raw");
  ASSERT_EQ(grey.size(), size.pixels());
  for (std::size_t i = 0; i < grey.size(); ++i)
    ASSERT_EQ(static_cast<unsigned char>(grey[i]), mask.pixels()[i] != 0 ? 255 : 0) << "pixel " << i;
}

TEST(VideoWriter, same_frames_give_the_same_bytes) {
  const TempFolder folder;
  for (const char* name : {"a.mp4", "b.mp4"}) {
    VideoWriter writer(folder.file(name), {160, 96});
    for (int i = 0; i < 30; ++i) writer.write(smooth_picture({160, 96}, i));
    writer.finish();
  }
  EXPECT_EQ(folder.read("a.mp4"), folder.read("b.mp4"));
  EXPECT_FALSE(folder.read("a.mp4").empty());
}

TEST(VideoWriter, table_of_contents_comes_first) {
  const TempFolder folder;
  write_numbered_clip(folder.file("a.mp4"), {16, 16}, 3);
  const std::string bytes = folder.read("a.mp4");
  EXPECT_LT(bytes.find("moov"), bytes.find("mdat"));
}

TEST(VideoWriter, frame_rates_are_kept) {
  const TempFolder folder;
  for (const double fps : {0.5, 16.0, 24000.0 / 1001, 29.97, 120.0}) {
    VideoWriterOptions options;
    options.fps = fps;
    VideoWriter writer(folder.file("a.mp4"), {16, 16}, options);
    for (int i = 0; i < 10; ++i) writer.write(numbered_picture({16, 16}, i));
    writer.finish();
    Monitor monitor;
    const auto clip = open_clip(folder.file("a.mp4"), whole_clip_unresized(), monitor);
    EXPECT_NEAR(clip->info().fps, fps, 1e-3 * fps);
    EXPECT_FALSE(clip->info().variable_frame_rate) << fps;
  }
}

TEST(VideoWriter, unfinished_files_are_removed) {
  const TempFolder folder;
  {
    VideoWriter writer(folder.file("a.mp4"), {16, 16});
    for (int i = 0; i < 30; ++i) writer.write(numbered_picture({16, 16}, i));
    EXPECT_TRUE(std::filesystem::exists(folder.file("a.mp4")));
  }
  EXPECT_FALSE(std::filesystem::exists(folder.file("a.mp4")));
}

TEST(VideoWriter, caller_mistakes_are_refused) {
  const TempFolder folder;
  const std::string path = folder.file("a.mp4");
  EXPECT_THROW(VideoWriter(path, {0, 16}), std::invalid_argument);
  for (const auto spoil :
       {+[](VideoWriterOptions& o) { o.fps = 0; }, +[](VideoWriterOptions& o) { o.crf = 52; },
        +[](VideoWriterOptions& o) { o.preset = "warp"; }, +[](VideoWriterOptions& o) { o.threads = -1; }}) {
    VideoWriterOptions options;
    spoil(options);
    EXPECT_THROW(VideoWriter(path, {16, 16}, options), std::invalid_argument);
  }
  VideoWriter writer(path, {16, 16});
  EXPECT_THROW(writer.write(ImageRgb(16, 15)), std::invalid_argument);
  EXPECT_THROW(writer.write(GenerateMask(16, 16)), std::invalid_argument) << "a lossy mask would come back grey";
  EXPECT_THROW(writer.finish(), std::invalid_argument) << "no frames";
  expect_error(ErrorCode::value_invalid, path, [&] { VideoWriter(path, {20000, 16}); });
}

TEST(VideoWriter, unwritable_places_are_output_errors) {
  const std::string nowhere = "/nonexistent-folder/a.mp4";
  expect_error(ErrorCode::output_failed, nowhere, [&] { VideoWriter(nowhere, {16, 16}); });
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full to play a full disk";
  const std::string full = "/dev/full";
  expect_error(ErrorCode::output_failed, full, [&] {
    VideoWriter writer(full, {64, 64});
    for (int i = 0; i < 100; ++i) writer.write(smooth_picture({64, 64}, i));
    writer.finish();
  });
  EXPECT_TRUE(std::filesystem::exists(full)) << "a device must not be removed";
}

}  // namespace
}  // namespace uwv
