// SPDX-License-Identifier: Apache-2.0
// Real-world oddities, made by the ffmpeg program; skipped where it is missing.
#include <gtest/gtest.h>

#include "io/clip_fixtures.h"
#include "io/hostile.h"
#include "support/matchers.h"
#include "uwv/io/image_file.h"

namespace uwv {
namespace {

using namespace test;

class ExoticClip : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!have_ffmpeg()) GTEST_SKIP() << "no ffmpeg program";
    write_png(folder.file("picture.png"), smooth_picture(size));
    for (int i = 0; i < 20; ++i) write_png(folder.file(fmt::format("n{:02}.png", i)), numbered_picture({32, 32}, i));
  }

  // Encodes the smooth picture as one frame and reads it back.
  ImageRgb through(const std::string& arguments, const std::string& name) {
    if (!ffmpeg("-i " + folder.file("picture.png") + " -frames:v 1 " + arguments + " " + folder.file(name))) return {};
    return read_all(folder.file(name)).at(0);
  }

  static constexpr Size size{64, 48};
  TempFolder folder;
};

TEST_F(ExoticClip, formats_depths_and_tags) {
  struct Case {
    const char* what;
    const char* arguments;
    const char* name;
    double min_psnr;
  };
  const std::string x264 = "-c:v libx264 -crf 1 ";
  // ffmpeg would put chroma in the middle of its pixels without saying so; H.264's place for it is the left one.
  const std::string left = "out_h_chr_pos=0:out_v_chr_pos=128:";
  const std::string to709 = "-vf scale=out_color_matrix=bt709:out_range=";
  const std::string left709 = "-vf scale=" + left + "out_color_matrix=bt709:out_range=";
  const std::string tags = " -colorspace bt709 -color_primaries bt709 -color_trc bt709 ";
  const std::string limited = x264 + to709 + "tv -pix_fmt yuv444p -color_range tv" + tags;
  const std::string full = x264 + to709 + "pc -pix_fmt yuv444p -color_range pc" + tags;
  const std::string deep = x264 + left709 + "tv -pix_fmt yuv420p10le -color_range tv" + tags;
  const std::string untagged = x264 + "-vf scale=" + left + "out_color_matrix=bt601:out_range=tv -pix_fmt yuv420p";
  for (const Case& c :
       {Case{"4:4:4 limited", limited.c_str(), "a.mp4", 42}, Case{"4:4:4 full", full.c_str(), "b.mp4", 42},
        Case{"10-bit 4:2:0", deep.c_str(), "c.mp4", 40}, Case{"no tags, small: BT.601", untagged.c_str(), "d.mp4", 40},
        Case{"Motion JPEG (full range)", "-c:v mjpeg -q:v 1 -pix_fmt yuvj444p", "e.avi", 38},
        Case{"RGB H.264", "-c:v libx264rgb -qp 0", "f.mp4", 90},
        Case{"alpha, PNG in MOV", "-c:v png -pix_fmt rgba", "g.mov", 90},
        Case{"alpha, QuickTime animation", "-c:v qtrle -pix_fmt argb", "h.mov", 90},
        Case{"FFV1 in Matroska", "-c:v ffv1 -pix_fmt bgr0", "i.mkv", 90}, Case{"palette, GIF", "", "j.gif", 18}}) {
    const ImageRgb back = through(c.arguments, c.name);
    if (back.empty()) {
      std::printf("skipped: this ffmpeg cannot make %s\n", c.what);
      continue;
    }
    ASSERT_EQ(back.size(), size) << c.what;
    EXPECT_GT(psnr(back, smooth_picture(size)), c.min_psnr) << c.what;
    for (const double shift : mean_shift(back, smooth_picture(size)))
      EXPECT_LT(std::abs(shift), c.min_psnr < 30 ? 4.0 : 1.0) << c.what;
  }
}

TEST_F(ExoticClip, grey_video_is_grey) {
  for (const char* range : {"tv", "pc"}) {
    const ImageRgb back = through(
        fmt::format("-c:v libx264 -crf 1 -vf scale=out_range={0},format=gray -color_range {0}", range), "g.mp4");
    if (back.empty()) GTEST_SKIP() << "this ffmpeg cannot make grey H.264";
    int spread = 0;
    for (const Rgb8 p : back.pixels()) spread = std::max({spread, std::abs(p.r - p.g), std::abs(p.g - p.b)});
    EXPECT_LE(spread, 1);
  }
}

TEST_F(ExoticClip, rotation_metadata_is_applied_as_ffmpeg_does) {
  ASSERT_TRUE(ffmpeg("-i " + folder.file("picture.png") + " -frames:v 1 -c:v libx264 -crf 1 -pix_fmt yuv420p " +
                     folder.file("plain.mp4")));
  for (const int degrees : {90, 180, 270}) {
    const std::string turned = folder.file("turned.mp4");
    ASSERT_TRUE(
        ffmpeg("-i " + folder.file("plain.mp4") + fmt::format(" -c copy -metadata:s:v rotate={} ", degrees) + turned));
    ASSERT_TRUE(ffmpeg("-i " + turned + " -frames:v 1 " + folder.file("upright.png")));
    const ImageRgb upright = read_image(folder.file("upright.png"));
    Monitor monitor;
    const auto clip = open_clip(turned, whole_clip_unresized(), monitor);
    EXPECT_EQ(clip->info().source_size, upright.size());
    const ImageRgb frame = read_all(*clip).at(0);
    ASSERT_EQ(frame.size(), degrees == 180 ? size : (Size{size.height, size.width})) << degrees;
    EXPECT_GT(psnr(frame, upright), 35.0) << degrees;
  }
}

TEST_F(ExoticClip, variable_frame_rate_is_reported_and_every_frame_is_taken) {
  const std::string path = folder.file("vfr.mp4");
  if (!ffmpeg("-framerate 20 -i " + folder.file("n%02d.png") +
              " -vf \"setpts='if(lt(N,10),N,10+(N-10)*3)/(20*TB)'\" -vsync vfr -c:v libx264 -crf 5 -pix_fmt yuv420p " +
              path))
    GTEST_SKIP() << "this ffmpeg cannot make variable frame rates";
  RecordingMonitor monitor;
  const auto clip = open_clip(path, whole_clip_unresized(), monitor);
  EXPECT_TRUE(clip->info().variable_frame_rate);
  EXPECT_EQ(monitor.warnings.size(), 1U);
  const std::vector<ImageRgb> frames = read_all(*clip);
  ASSERT_EQ(frames.size(), 20U);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(number_of(frames[static_cast<std::size_t>(i)]), i);
}

TEST_F(ExoticClip, reordered_frames_come_in_presentation_order_in_every_container) {
  for (const char* name : {"a.mp4", "a.mkv", "a.avi", "a.ts", "a.mov", "a.flv"}) {
    const std::string path = folder.file(name);
    if (!ffmpeg("-framerate 20 -i " + folder.file("n%02d.png") + " -c:v libx264 -crf 5 -bf 3 -pix_fmt yuv420p " + path))
      continue;
    RecordingMonitor monitor;
    for (const long max_frames : {0L, 7L}) {
      ClipOptions options = whole_clip_unresized();
      options.max_frames = max_frames;
      const auto clip = open_clip(path, options, monitor);
      EXPECT_EQ(clip->frames(), max_frames == 0 ? 20 : 7) << name;
      const std::vector<ImageRgb> frames = read_all(*clip);
      ASSERT_EQ(static_cast<long>(frames.size()), clip->frames()) << name;
      for (std::size_t i = 0; i < frames.size(); ++i) EXPECT_EQ(number_of(frames[i]), static_cast<int>(i)) << name;
    }
    EXPECT_TRUE(monitor.warnings.empty()) << name << ": " << monitor.warnings[0];
  }
}

TEST_F(ExoticClip, edit_lists_hide_what_they_cut) {
  ASSERT_TRUE(ffmpeg("-framerate 20 -i " + folder.file("n%02d.png") +
                     " -c:v libx264 -crf 5 -bf 2 -g 20 -pix_fmt yuv420p " + folder.file("whole.mp4")));
  // A cut without re-encoding keeps the frames since the last key frame and hides them by an edit list.
  ASSERT_TRUE(ffmpeg("-ss 0.5 -i " + folder.file("whole.mp4") + " -c copy " + folder.file("cut.mp4")));
  RecordingMonitor monitor;
  const auto clip = open_clip(folder.file("cut.mp4"), whole_clip_unresized(), monitor);
  const std::vector<ImageRgb> frames = read_all(*clip);
  ASSERT_EQ(static_cast<long>(frames.size()), clip->frames());
  ASSERT_FALSE(frames.empty());
  EXPECT_EQ(number_of(frames.front()), 10);
  EXPECT_EQ(number_of(frames.back()), 19);
  EXPECT_TRUE(monitor.warnings.empty()) << monitor.warnings[0];
}

TEST_F(ExoticClip, animated_pictures_are_clips) {
  const std::string exact_greys = " -vf \"split[a][b];[a]palettegen[p];[b][p]paletteuse=dither=none\" ";
  for (const char* name : {"a.gif", "a.apng"}) {
    const std::string path = folder.file(name);
    if (!ffmpeg("-framerate 10 -i " + folder.file("n%02d.png") + exact_greys + path)) continue;
    Monitor monitor;
    const auto clip = open_clip(path, whole_clip_unresized(), monitor);
    EXPECT_EQ(clip->frames(), 20) << name;
    EXPECT_FALSE(clip->info().is_photo) << name;
    EXPECT_EQ(number_of(read_all(*clip).at(7)), 7) << name;
  }
}

TEST_F(ExoticClip, odd_sizes_and_wide_pixels) {
  const std::string path = folder.file("odd.mkv");
  ASSERT_TRUE(ffmpeg("-i " + folder.file("picture.png") +
                     " -frames:v 1 -vf scale=33:17,setsar=4/3 -c:v ffv1 -pix_fmt yuv420p " + path));
  RecordingMonitor monitor;
  const auto clip = open_clip(path, whole_clip_unresized(), monitor);
  EXPECT_EQ(clip->info().source_size, (Size{33, 17}));
  EXPECT_EQ(monitor.warnings.size(), 1U) << "pixels are not square";
  EXPECT_GT(psnr(read_all(*clip).at(0), resize(smooth_picture(size), {33, 17})), 30.0);
}

TEST_F(ExoticClip, cover_art_is_no_video) {
  const std::string tone = "-f lavfi -i sine=duration=0.2 ";
  const std::string cover = folder.file("cover.m4a");
  if (!ffmpeg(tone + "-i " + folder.file("picture.png") +
              " -map 0 -map 1 -c:a aac -c:v png -disposition:v:0 attached_pic -f mp4 " + cover))
    GTEST_SKIP() << "this ffmpeg cannot make cover art";
  expect_error(ErrorCode::format_unknown, cover, [&] { read_all(cover); });
  // Beside a real video the cover must not be chosen, whichever comes first.
  const std::string both = folder.file("both.mp4");
  ASSERT_TRUE(ffmpeg("-i " + folder.file("picture.png") + " -framerate 20 -i " + folder.file("n%02d.png") +
                     " -map 0 -map 1 -c:v:0 png -c:v:1 libx264 -crf 5 -pix_fmt:v:1 yuv420p "
                     "-disposition:v:0 attached_pic -disposition:v:1 default " +
                     both));
  const std::vector<ImageRgb> frames = read_all(both);
  ASSERT_EQ(frames.size(), 20U);
  EXPECT_EQ(number_of(frames[5]), 5);
}

}  // namespace
}  // namespace uwv
