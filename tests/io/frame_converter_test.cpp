// SPDX-License-Identifier: Apache-2.0
// The pixel side of video reading: turning, and every kind of YCbCr against the definition.
#include "io/frame_converter.h"

#include <gtest/gtest.h>

#include <cstring>

#include "support/matchers.h"

namespace uwv {
namespace {

libav::Frame new_frame(AVPixelFormat format, Size size) {
  libav::Frame frame = libav::new_frame();
  frame->format = format;
  frame->width = size.width;
  frame->height = size.height;
  EXPECT_EQ(av_frame_get_buffer(frame.get(), 0), 0);
  return frame;
}

TEST(FrameConverter, all_eight_orientations_move_pixels_where_the_matrix_says) {
  const Size stored{3, 2};
  const libav::Frame frame = new_frame(AV_PIX_FMT_RGB24, stored);
  for (int y = 0; y < stored.height; ++y)
    for (int x = 0; x < stored.width; ++x)
      frame->data[0][y * frame->linesize[0] + 3 * x] = static_cast<std::uint8_t>(10 * y + x);
  for (const bool swap : {false, true})
    for (const int a : {1, -1})
      for (const int b : {1, -1}) {
        const Orientation o = swap ? Orientation{0, a, b, 0} : Orientation{a, 0, 0, b};
        ImageRgb shown;
        FrameConverter(o.shown(stored), o).convert(*frame, "x", shown);
        ASSERT_EQ(shown.size(), o.shown(stored));
        for (int y = 0; y < stored.height; ++y)
          for (int x = 0; x < stored.width; ++x) {
            const int to_x = o.xx * x + o.xy * y + (a > 0 ? 0 : shown.width() - 1);
            const int to_y = o.yx * x + o.yy * y + (b > 0 ? 0 : shown.height() - 1);
            EXPECT_EQ(shown(to_x, to_y).r, 10 * y + x) << "swap " << swap << " signs " << a << " " << b;
          }
      }
}

std::optional<Orientation> orientation_from(double degrees, bool mirror) {
  libav::DisplayMatrix matrix{};
  av_display_rotation_set(matrix.data(), degrees);
  if (mirror) av_display_matrix_flip(matrix.data(), 1, 0);
  return orientation_of(matrix);
}

TEST(FrameConverter, display_matrices) {
  EXPECT_EQ(orientation_from(0, false), (Orientation{1, 0, 0, 1}));
  EXPECT_EQ(orientation_from(180, false), (Orientation{-1, 0, 0, -1}));
  EXPECT_EQ(orientation_from(90, false), (Orientation{0, -1, 1, 0})) << "clockwise: up goes to the right";
  EXPECT_EQ(orientation_from(-90, false), (Orientation{0, 1, -1, 0}));
  EXPECT_EQ(orientation_from(0, true), (Orientation{-1, 0, 0, 1}));
  EXPECT_FALSE(orientation_from(45, false));
  EXPECT_FALSE(orientation_from(3, false));
}

struct YcbcrCase {
  AVPixelFormat format;
  AVColorSpace matrix;
  AVColorRange range;
  double red_weight, blue_weight;
};

// One colour through the textbook equations, to whole codes of `depth` bits.
std::array<int, 3> codes_of(Rgb8 colour, const YcbcrCase& c, int depth) {
  const double r = colour.r / 255.0, g = colour.g / 255.0, b = colour.b / 255.0;
  const double luma = c.red_weight * r + (1 - c.red_weight - c.blue_weight) * g + c.blue_weight * b;
  const double cb = (b - luma) / (2 * (1 - c.blue_weight)), cr = (r - luma) / (2 * (1 - c.red_weight));
  const double unit = std::ldexp(1.0, depth - 8), top = std::ldexp(1.0, depth) - 1;
  const auto code = [top](double v) { return static_cast<int>(std::min(std::round(v), top)); };
  if (c.range == AVCOL_RANGE_JPEG) return {code(luma * top), code(cb * top + 128 * unit), code(cr * top + 128 * unit)};
  return {code((219 * luma + 16) * unit), code((224 * cb + 128) * unit), code((224 * cr + 128) * unit)};
}

void fill(AVFrame& frame, const std::array<int, 3>& codes, int depth) {
  for (int plane = 0; plane < 3 && frame.data[plane] != nullptr; ++plane)
    for (int y = 0; y < (plane > 0 ? AV_CEIL_RSHIFT(frame.height, 1) : frame.height); ++y)
      for (int i = 0; i < frame.linesize[plane] / (depth > 8 ? 2 : 1); ++i) {
        std::uint8_t* row = frame.data[plane] + y * frame.linesize[plane];
        if (depth == 8)
          row[i] = static_cast<std::uint8_t>(codes[static_cast<std::size_t>(plane)]);
        else
          reinterpret_cast<std::uint16_t*>(row)[i] = static_cast<std::uint16_t>(codes[static_cast<std::size_t>(plane)]);
      }
}

TEST(FrameConverter, every_matrix_range_and_depth_follows_its_definition) {
  const std::array<YcbcrCase, 8> cases{{
      {AV_PIX_FMT_YUV420P, AVCOL_SPC_BT709, AVCOL_RANGE_MPEG, 0.2126, 0.0722},
      {AV_PIX_FMT_YUV420P, AVCOL_SPC_BT709, AVCOL_RANGE_JPEG, 0.2126, 0.0722},
      {AV_PIX_FMT_YUV420P, AVCOL_SPC_SMPTE170M, AVCOL_RANGE_MPEG, 0.299, 0.114},
      {AV_PIX_FMT_YUVJ420P, AVCOL_SPC_BT470BG, AVCOL_RANGE_JPEG, 0.299, 0.114},
      {AV_PIX_FMT_YUV420P10, AVCOL_SPC_BT2020_NCL, AVCOL_RANGE_MPEG, 0.2627, 0.0593},
      {AV_PIX_FMT_YUV420P10, AVCOL_SPC_BT709, AVCOL_RANGE_JPEG, 0.2126, 0.0722},
      {AV_PIX_FMT_YUV420P16, AVCOL_SPC_SMPTE240M, AVCOL_RANGE_JPEG, 0.212, 0.087},
      {AV_PIX_FMT_YUV420P, AVCOL_SPC_UNSPECIFIED, AVCOL_RANGE_UNSPECIFIED, 0.299, 0.114},
  }};
  const Size size{10, 6};
  for (const YcbcrCase& c : cases)
    for (const Rgb8 colour : {Rgb8{0, 0, 0}, Rgb8{255, 255, 255}, Rgb8{255, 0, 0}, Rgb8{0, 255, 0}, Rgb8{0, 0, 255},
                              Rgb8{12, 200, 90}, Rgb8{128, 128, 128}}) {
      const libav::Frame frame = new_frame(c.format, size);
      const int depth = av_pix_fmt_desc_get(c.format)->comp[0].depth;
      fill(*frame, codes_of(colour, c, depth), depth);
      frame->colorspace = c.matrix;
      frame->color_range = c.range;
      ImageRgb out;
      FrameConverter(size, {}).convert(*frame, "x", out);
      SCOPED_TRACE(fmt::format("{} {} {}", av_get_pix_fmt_name(c.format), av_color_space_name(c.matrix), c.range));
      EXPECT_IMAGE_NEAR(out, ImageRgb(size, colour), depth == 8 ? 2 : 1);
    }
}

TEST(FrameConverter, unspecified_matrix_is_bt709_from_720_lines_on) {
  for (const int height : {718, 720}) {
    const libav::Frame frame = new_frame(AV_PIX_FMT_YUV420P, {16, height});
    fill(*frame, {100, 90, 160}, 8);
    ImageRgb guessed, known;
    FrameConverter converter({16, height}, {});
    converter.convert(*frame, "x", guessed);
    frame->colorspace = height == 720 ? AVCOL_SPC_BT709 : AVCOL_SPC_SMPTE170M;
    converter.convert(*frame, "x", known);
    EXPECT_IMAGE_NEAR(guessed, known, 0);
  }
}

TEST(FrameConverter, grey_follows_its_range) {
  for (const bool full : {false, true}) {
    const libav::Frame frame = new_frame(AV_PIX_FMT_GRAY8, {5, 3});
    frame->color_range = full ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
    for (const int code : {16, 126, 235}) {
      for (int y = 0; y < 3; ++y) std::memset(frame->data[0] + y * frame->linesize[0], code, 5);
      const auto level = static_cast<std::uint8_t>(std::lround(full ? code : (code - 16) * 255 / 219.0));
      ImageRgb out;
      FrameConverter({5, 3}, {}).convert(*frame, "x", out);
      EXPECT_IMAGE_NEAR(out, ImageRgb(5, 3, {level, level, level}), 0);
    }
  }
}

}  // namespace
}  // namespace uwv
