// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/image_file.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace uwv {
namespace {

constexpr int largest_side = 65535;

// The number of colour components a JPEG's frame header promises; 0 when the file is no JPEG or has no such header.
int jpeg_components(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (file.get() != 0xFF || file.get() != 0xD8) return 0;
  while (file.get() == 0xFF) {
    int marker = file.get();
    while (marker == 0xFF) marker = file.get();  // fill bytes
    std::array<unsigned char, 8> head{};
    if (!file.read(reinterpret_cast<char*>(head.data()), 2)) return 0;
    const int length = head[0] * 256 + head[1];
    const bool is_frame_header = marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (is_frame_header) return file.read(reinterpret_cast<char*>(head.data()), 6) ? head[5] : 0;
    if (length < 2 || marker == 0xDA) return 0;
    file.seekg(length - 2, std::ios::cur);
  }
  return 0;
}

void require_readable(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) fail(ErrorCode::file_not_found, "{}: there is no such file", path);
  if (std::filesystem::is_directory(path, ignored))
    fail(ErrorCode::format_unknown, "{}: is a folder; a picture file is wanted", path);
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(ErrorCode::file_not_found, "{}: cannot be opened for reading", path);
  if (file.peek() == std::ifstream::traits_type::eof())
    fail(ErrorCode::file_damaged, "{}: is empty (0 bytes); a picture is wanted", path);
}

cv::Mat decode(const std::string& path) {
  try {
    return cv::imread(path, cv::IMREAD_COLOR | cv::IMREAD_ANYDEPTH);
  } catch (const cv::Exception& error) {
    if (error.code == cv::Error::StsNoMem)
      fail(ErrorCode::out_of_memory, "{}: not enough memory to decode this picture; use a smaller one", path);
    // OpenCV checks the header's size against its own limit of 2^30 pixels before it allocates.
    fail(ErrorCode::value_invalid,
         "{}: its header asks for an impossible picture; at most 65535 pixels a side and 2^30 in all are accepted",
         path);
  }
}

cv::Mat to_8_bit(const cv::Mat& decoded, const std::string& path) {
  if (decoded.depth() == CV_8U) return decoded;
  if (decoded.depth() != CV_16U)
    fail(ErrorCode::format_unknown, "{}: its samples are not 8 or 16-bit integers; convert it to an 8-bit PNG", path);
  cv::Mat narrow;
  decoded.convertTo(narrow, CV_8U, 1.0 / 257.0);
  return narrow;
}

// A view, not a copy; the caller keeps the picture alive. OpenCV has no const Mat, so only reading calls get it.
cv::Mat view(const ImageRgb& picture) {
  return {picture.height(), picture.width(), CV_8UC3, const_cast<Rgb8*>(picture.data())};
}

void write_png_matrix(const std::string& path, const cv::Mat& matrix) {
  bool written = false;
  try {
    // Level 3 with the default strategy: about a third of the time of level 9 for 5 % more bytes.
    std::vector<unsigned char> bytes;
    cv::imencode(".png", matrix, bytes, {cv::IMWRITE_PNG_COMPRESSION, 3});
    std::ofstream file(path, std::ios::binary | std::ios::trunc);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    file.close();
    written = static_cast<bool>(file);
  } catch (const cv::Exception&) {
    written = false;
  }
  if (!written)
    fail(ErrorCode::output_failed, "{}: cannot be written; check the folder, its permissions and the disk", path);
}

void write_png_mask(const std::string& path, const Image<std::uint8_t>& mask) {
  require(!mask.empty(), "{}: an empty mask cannot be written", path);
  cv::Mat levels(mask.height(), mask.width(), CV_8UC1);
  std::transform(mask.pixels().begin(), mask.pixels().end(), levels.data,
                 [](std::uint8_t v) { return static_cast<std::uint8_t>(v != 0 ? 255 : 0); });
  write_png_matrix(path, levels);
}

}  // namespace

ImageRgb read_image(const std::string& path) {
  require_readable(path);
  if (!cv::haveImageReader(path))
    fail(ErrorCode::format_unknown, "{}: is no picture in a known format; PNG, JPEG, TIFF, WebP, BMP or PNM is wanted",
         path);
  if (jpeg_components(path) == 4)
    fail(ErrorCode::format_unknown, "{}: is a CMYK picture, whose colours depend on a print profile; convert it to RGB",
         path);
  const cv::Mat decoded = decode(path);
  if (decoded.empty())
    fail(ErrorCode::file_damaged, "{}: starts like a picture but cannot be decoded; it is damaged or cut short", path);
  if (decoded.cols > largest_side || decoded.rows > largest_side)
    fail(ErrorCode::value_invalid, "{}: is {}x{} pixels; at most {} a side are accepted", path, decoded.cols,
         decoded.rows, largest_side);
  ImageRgb picture(decoded.cols, decoded.rows);
  cv::Mat target = view(picture);
  cv::cvtColor(to_8_bit(decoded, path), target, cv::COLOR_BGR2RGB);
  return picture;
}

void write_png(const std::string& path, const ImageRgb& picture) {
  require(!picture.empty(), "{}: an empty picture cannot be written", path);
  cv::Mat bgr;
  cv::cvtColor(view(picture), bgr, cv::COLOR_RGB2BGR);
  write_png_matrix(path, bgr);
}

void write_png(const std::string& path, const ValidityMask& mask) { write_png_mask(path, mask); }
void write_png(const std::string& path, const GenerateMask& mask) { write_png_mask(path, mask); }

ImageRgb resize(const ImageRgb& picture, Size size) {
  require(!picture.empty() && size.width > 0 && size.height > 0, "cannot resize a picture of {}x{} to {}x{}",
          picture.width(), picture.height(), size.width, size.height);
  if (picture.size() == size) return picture;
  ImageRgb resized(size);
  cv::Mat target = view(resized);
  // Shrinking first and growing second treats each axis by its own rule, also when one shrinks and the other grows.
  const cv::Size smaller(std::min(picture.width(), size.width), std::min(picture.height(), size.height));
  if (smaller == target.size()) {
    cv::resize(view(picture), target, smaller, 0, 0, cv::INTER_AREA);
    return resized;
  }
  cv::Mat shrunk = view(picture);
  if (smaller != shrunk.size()) cv::resize(view(picture), shrunk, smaller, 0, 0, cv::INTER_AREA);
  cv::resize(shrunk, target, target.size(), 0, 0, cv::INTER_CUBIC);
  return resized;
}

}  // namespace uwv
