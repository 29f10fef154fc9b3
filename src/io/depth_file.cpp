// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/depth_file.h"

#include <array>
#include <cmath>
#include <filesystem>

#include "io/depth_array.h"
#include "io/depth_codecs.h"
#include "io/disk_file.h"

namespace uwv {
namespace {

std::string first_bytes(const std::string& path) {
  const io::InputFile file(path);
  std::string start(std::min<std::uint64_t>(file.size(), 8), '\0');
  file.read_at(0, std::as_writable_bytes(std::span(start)));
  return start;
}

DepthMap read_array(const std::string& path, const DepthFileOptions& options) {
  io::DepthArray array(path, options.key);
  if (array.frames() != 1)
    fail(ErrorCode::value_invalid, "{}: holds {} frames of depth where one is wanted", path, array.frames());
  DepthMap depth;
  array.read(0, options.scale == 0 ? 1 : options.scale, depth);
  return depth;
}

DepthMap read_stored(const std::string& path, const DepthFileOptions& options) {
  const std::string start = first_bytes(path);
  const double scale = options.scale == 0 ? 1 : options.scale;
  if (start.starts_with("\x89PNG\r\n\x1a\n"))
    return io::read_png_depth(path, options.scale == 0 ? io::default_png_scale : options.scale);
  if (start.starts_with("\x76\x2f\x31\x01")) return io::read_exr_depth(path, scale);
  if (start.starts_with("Pf") || start.starts_with("PF")) return io::read_pfm_depth(path, scale);
  if (io::is_numpy_file(path)) return read_array(path, options);
  if (start.size() < 8) fail(ErrorCode::file_damaged, "{}: {} bytes are too few for a depth file", path, start.size());
  fail(ErrorCode::format_unknown, "{}: is no depth file; .npy, .npz, 16-bit .png, .exr or .pfm is wanted", path);
}

}  // namespace

void DepthFileOptions::check() const {
  require(std::isfinite(scale) && scale >= 0, "a depth scale of {} is not a positive number (or 0 = default)", scale);
}

DepthMap read_depth_file(const std::string& path, const DepthFileOptions& options) {
  options.check();
  DepthMap depth = read_stored(path, options);
  sanitize_depth(depth);
  return depth;
}

DepthLoss write_depth_file(const std::string& path, const DepthMap& depth, const DepthFileOptions& options) {
  options.check();
  const std::string extension = std::filesystem::path(path).extension().string();
  const double scale = options.scale == 0 ? 1 : options.scale;
  if (extension == ".png")
    return io::write_png_depth(path, depth, options.scale == 0 ? io::default_png_scale : options.scale);
  if (extension == ".exr") {
    io::write_exr_depth(path, depth, scale);
  } else if (extension == ".pfm") {
    io::write_pfm_depth(path, depth, scale);
  } else if (extension == ".npy") {
    DepthMap scaled = depth;
    if (scale != 1)
      for (float& z : scaled.pixels()) z = static_cast<float>(z / scale);
    write_npy<float>(path, {static_cast<std::size_t>(depth.height()), static_cast<std::size_t>(depth.width())},
                     scaled.pixels());
  } else {
    fail(ErrorCode::format_unknown, "{}: depth is written as .npy, .png, .exr or .pfm", path);
  }
  return {};
}

}  // namespace uwv
