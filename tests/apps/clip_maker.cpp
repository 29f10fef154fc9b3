// SPDX-License-Identifier: Apache-2.0
#include "apps/clip_maker.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "uwv/io/npy.h"
#include "uwv/io/video_writer.h"

namespace uwv::test {
namespace {

namespace fs = std::filesystem;

bool on_square(const ClipSpec& spec, long index, int x, int y) {
  const int side = std::max(1, spec.size.height / 3);
  const int left = spec.size.width / 4 + static_cast<int>(index % 8);
  const int top = spec.size.height / 3;
  return x >= left && x < left + side && y >= top && y < top + side;
}

std::uint8_t wave(double phase) { return static_cast<std::uint8_t>(128 + 100 * std::sin(phase)); }

}  // namespace

ImageRgb clip_picture(const ClipSpec& spec, long index) {
  ImageRgb picture(spec.size);
  for (int y = 0; y < spec.size.height; ++y)
    for (int x = 0; x < spec.size.width; ++x)
      picture(x, y) = on_square(spec, index, x, y) ? Rgb8{220, wave(0.5 * x), 40}
                                                   : Rgb8{wave(0.2 * x), wave(0.15 * y), wave(0.1 * (x + y))};
  return picture;
}

DepthMap clip_depth(const ClipSpec& spec, long index) {
  DepthMap depth(spec.size);
  for (int y = 0; y < spec.size.height; ++y)
    for (int x = 0; x < spec.size.width; ++x) depth(x, y) = on_square(spec, index, x, y) ? 2.0F : 4.0F;
  return depth;
}

void make_clip(const TempFolder& folder, const ClipSpec& spec) {
  VideoWriter video(folder.file("clip.mp4"), spec.size, {.fps = 16, .crf = 10, .threads = 1});
  NpzWriter depth(folder.file("depth.npz"));
  const auto height = static_cast<std::size_t>(spec.size.height), width = static_cast<std::size_t>(spec.size.width);
  depth.begin("depth", DType::f32, {height, width});
  for (long i = 0; i < spec.frames; ++i) {
    video.write(clip_picture(spec, i));
    const DepthMap map = clip_depth(spec, i);
    depth.append(map.pixels());
  }
  video.finish();
  depth.end();
  depth.finish();
}

std::vector<std::string> run_arguments(const std::string& out, const std::vector<std::string>& more) {
  std::vector<std::string> all = {"--video", "clip.mp4", "--depth",     "depth.npz", "--fov", "60",
                                  "--traj",  "left",     "--no-resize", "--out",     out};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

std::map<std::string, std::string> results(const std::string& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = fs::relative(entry.path(), folder).string();
    if (!entry.is_regular_file() || name == "run.json" || name.starts_with(".stage-")) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    files[name] = {std::istreambuf_iterator<char>(file), {}};
  }
  return files;
}

std::vector<std::string> listing(const std::string& folder) {
  std::vector<std::string> lines;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = fs::relative(entry.path(), folder).string();
    if (name == ".stdout" || name == ".stderr") continue;
    const bool is_file = entry.is_regular_file();
    lines.push_back(fmt::format("{} {} {}", name, is_file ? entry.file_size() : 0,
                                is_file ? entry.last_write_time().time_since_epoch().count() : 0));
  }
  std::sort(lines.begin(), lines.end());
  return lines;
}

}  // namespace uwv::test
