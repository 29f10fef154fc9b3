// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "io/depth_codecs.h"
#include "io/disk_file.h"
#include "io/printable.h"

namespace uwv::io {
namespace {

constexpr float max_level = 65535;

std::uint32_t big_endian(std::span<const std::byte> bytes) {
  std::uint32_t value = 0;
  for (const std::byte b : bytes.first(4)) value = value << 8 | std::to_integer<std::uint32_t>(b);
  return value;
}

/// Checks what the file claims to be before a decoder allocates anything for it.
Size check_header(const std::string& path) {
  constexpr std::size_t header_bytes = 26;  // signature, chunk length and name, width, height, depth, colour type
  std::array<std::byte, header_bytes> header{};
  const InputFile file(path);
  file.read_at(0, header);
  const int bits = std::to_integer<int>(header[24]), colour_type = std::to_integer<int>(header[25]);
  constexpr int grey = 0;
  if (bits != 16 || colour_type != grey)
    fail(ErrorCode::format_unknown,
         "{}: is a {}-bit {} PNG, which holds no depth; a 16-bit grey one is wanted (write it from 16-bit integers)",
         path, bits, colour_type == grey ? "grey" : "colour");
  const Size size =
      checked_size(big_endian(std::span(header).subspan(16)), big_endian(std::span(header).subspan(20)), path);
  constexpr std::uint64_t best_deflate_ratio = 1032;
  if (size.pixels() * 2 / best_deflate_ratio > file.size())
    fail(ErrorCode::file_damaged, "{}: claims {}x{} pixels in {} bytes, which PNG cannot reach", path, size.width,
         size.height, file.size());
  return size;
}

}  // namespace

DepthMap read_png_depth(const std::string& path, double scale) {
  const Size size = check_header(path);
  cv::Mat levels;
  try {
    levels = cv::imread(path, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& error) {
    fail(ErrorCode::file_damaged, "{}: cannot be decoded: {}", path, printable(error.err));
  }
  if (levels.type() != CV_16UC1 || levels.cols != size.width || levels.rows != size.height)
    fail(ErrorCode::file_damaged, "{}: its pixels cannot be decoded; the file was damaged or cut short", path);
  DepthMap depth(size);
  for (int y = 0; y < size.height; ++y) {
    const auto* from = levels.ptr<std::uint16_t>(y);
    float* to = depth.row(y);
    for (int x = 0; x < size.width; ++x) to[x] = static_cast<float>(from[x] * scale);
  }
  return depth;
}

DepthLoss write_png_depth(const std::string& path, const DepthMap& depth, double scale) {
  require(!depth.empty(), "{}: an empty depth map cannot be written", path);
  DepthLoss loss;
  cv::Mat levels(depth.height(), depth.width(), CV_16UC1);
  const double levels_per_unit = 1 / scale;
  for (int y = 0; y < depth.height(); ++y) {
    const float* from = depth.row(y);
    auto* to = levels.ptr<std::uint16_t>(y);
    for (int x = 0; x < depth.width(); ++x) {
      const double level = is_valid_depth(from[x]) ? std::floor(from[x] * levels_per_unit + 0.5) : 0;
      loss.too_far += level > max_level;
      loss.too_near += level < 1 && is_valid_depth(from[x]);
      to[x] = level > max_level ? 0 : static_cast<std::uint16_t>(level);
    }
  }
  std::vector<std::uint8_t> bytes;
  // As fast as OpenCV's own default (run lengths only), and four times smaller on smooth surfaces.
  constexpr int fastest_zlib_level = 1;
  cv::imencode(".png", levels, bytes, {cv::IMWRITE_PNG_COMPRESSION, fastest_zlib_level});
  write_file(path, std::as_bytes(std::span(bytes)));
  return loss;
}

}  // namespace uwv::io
