// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/image_file.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "io/clip_fixtures.h"
#include "io/hostile.h"
#include "support/matchers.h"

namespace uwv {
namespace {

using test::expect_error;
using test::smooth_picture;
using test::TempFolder;

TEST(ImageFile, png_round_trip_is_exact) {
  const TempFolder folder;
  for (const Size size : {Size{1, 1}, Size{3, 2}, Size{33, 17}, Size{640, 2}}) {
    const ImageRgb picture = smooth_picture(size);
    write_png(folder.file("a.png"), picture);
    EXPECT_IMAGE_NEAR(read_image(folder.file("a.png")), picture, 0);
  }
}

TEST(ImageFile, masks_become_black_and_white) {
  const TempFolder folder;
  GenerateMask mask(3, 1, 0);
  mask(1, 0) = 1;
  mask(2, 0) = 7;
  write_png(folder.file("generate_mask.png"), mask);
  const ImageRgb back = read_image(folder.file("generate_mask.png"));
  EXPECT_EQ(back(0, 0), (Rgb8{0, 0, 0}));
  EXPECT_EQ(back(1, 0), (Rgb8{255, 255, 255}));
  EXPECT_EQ(back(2, 0), (Rgb8{255, 255, 255}));
}

TEST(ImageFile, grey_deep_and_transparent_pictures) {
  const TempFolder folder;
  cv::imwrite(folder.file("grey.png"), cv::Mat(2, 3, CV_8UC1, cv::Scalar(77)));
  EXPECT_EQ(read_image(folder.file("grey.png"))(2, 1), (Rgb8{77, 77, 77}));
  // 128 * 257 + 128 is just below half way to 129, one more just above.
  cv::imwrite(folder.file("deep.png"), cv::Mat(1, 1, CV_16UC3, cv::Scalar(65535, 128 * 257 + 128, 128 * 257 + 129)));
  EXPECT_EQ(read_image(folder.file("deep.png"))(0, 0), (Rgb8{129, 128, 255}));
  cv::imwrite(folder.file("alpha.png"), cv::Mat(1, 1, CV_8UC4, cv::Scalar(10, 20, 30, 0)));
  EXPECT_EQ(read_image(folder.file("alpha.png"))(0, 0), (Rgb8{30, 20, 10})) << "colours stay as stored";
}

// A JPEG whose EXIF block says "row 0 is the right-hand side": to be turned clockwise for display.
std::string turned_jpeg(const std::string& plain) {
  const std::string tiff("MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0", 26);
  const std::string body = std::string("Exif\0\0", 6) + tiff;
  const std::string length{'\0', static_cast<char>(body.size() + 2)};
  return plain.substr(0, 2) + "\xFF\xE1" + length + body + plain.substr(2);
}

TEST(ImageFile, exif_orientation_is_applied) {
  const TempFolder folder;
  cv::Mat picture(32, 64, CV_8UC3, cv::Scalar(0, 0, 0));
  picture.colRange(0, 32).setTo(cv::Scalar(255, 255, 255));  // white on the left, so on top after turning
  cv::imwrite(folder.file("plain.jpg"), picture, {cv::IMWRITE_JPEG_QUALITY, 100});
  folder.write("turned.jpg", turned_jpeg(folder.read("plain.jpg")));
  const ImageRgb turned = read_image(folder.file("turned.jpg"));
  ASSERT_EQ(turned.size(), (Size{32, 64}));
  EXPECT_GT(turned(16, 8).g, 250);
  EXPECT_LT(turned(16, 56).g, 5);
}

TEST(ImageFile, unusable_pictures_are_refused_by_name) {
  const TempFolder folder;
  const auto read = [](const std::string& path) { return [path] { read_image(path); }; };
  expect_error(ErrorCode::file_not_found, folder.file("none.png"), read(folder.file("none.png")));
  expect_error(ErrorCode::format_unknown, folder.path().string(), read(folder.path().string()));
  const std::string empty = folder.write("empty.png", "");
  expect_error(ErrorCode::file_damaged, empty, read(empty));
  const std::string text = folder.write("text.png", "this is no picture");
  expect_error(ErrorCode::format_unknown, text, read(text));
  const std::string cmyk =
      folder.write("cmyk.jpg", std::string("\xFF\xD8\xFF\xE0\0\x04__\xFF\xC0\0\x14\x08\0\x10\0\x10\x04\x01\x11\0", 21));
  expect_error(ErrorCode::format_unknown, cmyk, read(cmyk));
  cv::imwrite(folder.file("float.tiff"), cv::Mat(2, 2, CV_32FC3, cv::Scalar(0.5, 0.5, 0.5)));
  expect_error(ErrorCode::format_unknown, folder.file("float.tiff"), read(folder.file("float.tiff")));
  std::string bmp("BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\x60\xEA\0\0\x60\xEA\0\0\x01\0\x18\0", 30);
  bmp.resize(200, '\0');
  const std::string absurd = folder.write("absurd.bmp", bmp);  // 60000x60000 pixels in 200 bytes
  expect_error(ErrorCode::value_invalid, absurd, read(absurd));
}

TEST(ImageFile, damaged_bytes_load_or_are_refused) {
  const TempFolder folder;
  write_png(folder.file("a.png"), smooth_picture({24, 16}));
  const auto read = [](const std::string& path) { read_image(path); };
  test::try_truncations(folder.read("a.png"), "a.png", read, 97);
  test::try_byte_flips(folder.read("a.png"), "a.png", read, 40);
}

TEST(ImageFile, unwritable_place_is_an_output_error) {
  const std::string path = "/nonexistent-folder/a.png";
  expect_error(ErrorCode::output_failed, path, [&] { write_png(path, ImageRgb(1, 1)); });
}

TEST(Resize, keeps_flat_colours_and_equal_sizes) {
  const ImageRgb flat(31, 23, {200, 100, 50});
  for (const Size size : {Size{1, 1}, Size{10, 7}, Size{62, 46}, Size{10, 60}, Size{70, 5}})
    EXPECT_IMAGE_NEAR(resize(flat, size), ImageRgb(size, {200, 100, 50}), 0);
  const ImageRgb picture = smooth_picture({31, 23});
  EXPECT_IMAGE_NEAR(resize(picture, {31, 23}), picture, 0);
  EXPECT_THROW(resize(picture, {0, 3}), std::invalid_argument);
}

TEST(Resize, shrinking_averages_and_nothing_shifts) {
  ImageRgb squares(4, 2);
  for (int x = 0; x < 4; ++x) squares(x, 0).r = squares(x, 1).r = static_cast<std::uint8_t>(x * 40);
  const ImageRgb half = resize(squares, {2, 1});
  EXPECT_EQ(half(0, 0).r, 20);
  EXPECT_EQ(half(1, 0).r, 100);
  const ImageRgb picture = smooth_picture({48, 32});
  EXPECT_GT(test::psnr(resize(resize(picture, {96, 64}), {48, 32}), picture), 50.0);
}

}  // namespace
}  // namespace uwv
