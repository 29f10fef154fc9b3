// SPDX-License-Identifier: Apache-2.0
#include "bench/stereo_pairs.h"

#include <algorithm>
#include <array>
#include <filesystem>

#include "uwv/io/depth_file.h"
#include "uwv/io/depth_source.h"
#include "uwv/io/frame_source.h"
#include "uwv/io/image_file.h"

namespace uwv::bench {
namespace {

/// Where a pair's files are and what its disparities mean.
struct Layout {
  std::array<const char*, 2> pictures;
  std::array<const char*, 2> disparities;  ///< "" = not measured.
  double pixels = 1;                       ///< A disparity of 1 in the file is so many pixels.
};

constexpr Layout layouts[] = {{{"im2.png", "im6.png"}, {"disp2.png", "disp6.png"}, 1.0 / 4},
                              {{"view1.png", "view5.png"}, {"disp1.png", "disp5.png"}, 1.0 / 2},
                              {{"motorcycle_left.png", "motorcycle_right.png"}, {"motorcycle_disp.npz", ""}, 1}};

const Layout* layout_of(const std::string& folder) {
  for (const Layout& layout : layouts)
    if (std::filesystem::exists(folder + "/" + layout.pictures[0])) return &layout;
  return nullptr;
}

/// Depth is focal * baseline / (disparity + doffs); the right camera's centre lies doffs further right in its picture.
struct Calibration {
  Intrinsics left;
  double doffs = 0;
  double baseline = 1;
};

Calibration calibration(const Layout& layout, Size full) {
  // Both cameras' principal points count pixel centres the same way, so which way does not matter: only their
  // difference moves a pixel.
  if (layout.disparities[1][0] == '\0') return {{994.978, 994.978, 311.193, 254.877}, 31.086, 193.001};
  const auto focal = static_cast<double>(full.width);
  return {{focal, focal, full.width / 2.0, full.height / 2.0}, 0, 1};
}

/// Middlebury's pictures of disparity have 8 bits, which no depth file has.
DepthMap read_disparity(const std::string& path, double pixels) {
  if (!path.ends_with(".png")) return read_depth_file(path, {.scale = pixels, .key = ""});
  const ImageRgb picture = read_image(path);
  DepthMap disparity(picture.size());
  std::transform(picture.pixels().begin(), picture.pixels().end(), disparity.pixels().begin(),
                 [&](const Rgb8& grey) { return static_cast<float>(pixels * grey.g); });
  return disparity;
}

DepthMap read_depth(const std::string& path, double pixels, const Calibration& lens, Size full) {
  DepthMap depth = read_disparity(path, pixels);
  if (depth.size() != full)
    fail(ErrorCode::size_mismatch, "{}: is {}x{}, its picture {}x{}; wanted one size", path, depth.width(),
         depth.height(), full.width, full.height);
  for (float& value : depth.pixels())
    if (value > 0) value = static_cast<float>(lens.left.fx * lens.baseline / (static_cast<double>(value) + lens.doffs));
  return depth;
}

}  // namespace

bool is_stereo_pair(const std::string& folder) { return layout_of(folder) != nullptr; }

TrueClip read_stereo_pair(const std::string& folder, const ResizePolicy& resize) {
  const Layout* layout = layout_of(folder);
  if (layout == nullptr)
    fail(ErrorCode::file_not_found, "{}: holds none of im2.png, view1.png and motorcycle_left.png", folder);
  Monitor monitor;
  TrueClip clip;
  clip.name = std::filesystem::path(folder).lexically_normal().filename().string();
  ClipOptions options;
  options.resize = resize;
  Size full;
  for (std::size_t side = 0; side < 2; ++side) {
    const std::string path = folder + "/" + layout->pictures[side];
    const auto source = open_clip(path, options, monitor);
    if (side == 1 && source->info().source_size != full)
      fail(ErrorCode::size_mismatch, "{}: is {}x{}, the left picture {}x{}; wanted one size", path,
           source->info().source_size.width, source->info().source_size.height, full.width, full.height);
    full = source->info().source_size;
    clip.frames.emplace_back();
    source->read(0, clip.frames.back());
    const Size size = clip.frames.front().size();
    const Calibration lens = calibration(*layout, full);
    Camera camera{lens.left, {}, full};
    if (side == 1) {
      camera.intrinsics.cx += lens.doffs;
      camera.world_from_cam.translation.x() = lens.baseline;
    }
    camera.intrinsics = camera.intrinsics.resized(full, size);
    camera.size = size;
    clip.cameras.push_back(camera);
    const std::string disparity = layout->disparities[side];
    clip.depths.push_back(disparity.empty()
                              ? DepthMap(size)
                              : resize_depth(read_depth(folder + "/" + disparity, layout->pixels, lens, full), size));
  }
  return clip;
}

}  // namespace uwv::bench
