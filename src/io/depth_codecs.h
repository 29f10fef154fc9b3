// SPDX-License-Identifier: Apache-2.0
// The picture formats of single depth maps. Readers return stored values times `scale`, not yet sanitised.
#pragma once

#include <string>

#include "uwv/core/image.h"
#include "uwv/io/depth_file.h"

namespace uwv::io {

inline constexpr double default_png_scale = 0.001;

/// The size, when both sides and the area are in reason (65536 a side, 2^28 pixels). Throws Error(file_damaged).
inline Size checked_size(std::uint64_t width, std::uint64_t height, const std::string& path) {
  constexpr std::uint64_t max_side = 1U << 16, max_pixels = 1U << 28;
  if (width == 0 || height == 0 || width > max_side || height > max_side || width * height > max_pixels)
    fail(ErrorCode::file_damaged, "{}: claims a picture of {}x{} pixels; 1x1 to {} a side and {} in all are read", path,
         width, height, max_side, max_pixels);
  return {static_cast<int>(width), static_cast<int>(height)};
}

DepthMap read_png_depth(const std::string& path, double scale);
DepthLoss write_png_depth(const std::string& path, const DepthMap& depth, double scale);

DepthMap read_exr_depth(const std::string& path, double scale);
void write_exr_depth(const std::string& path, const DepthMap& depth, double scale);

DepthMap read_pfm_depth(const std::string& path, double scale);
void write_pfm_depth(const std::string& path, const DepthMap& depth, double scale);

}  // namespace uwv::io
