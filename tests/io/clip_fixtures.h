// SPDX-License-Identifier: Apache-2.0
// Clips, pictures and measures shared by the tests of video and pictures.
#pragma once

#include <array>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "uwv/core/monitor.h"
#include "uwv/io/frame_source.h"
#include "uwv/io/video_writer.h"

namespace uwv::test {

/// Keeps the warnings of a job.
class RecordingMonitor : public Monitor {
 public:
  void warn(const std::string& sentence) override { warnings.push_back(sentence); }
  std::vector<std::string> warnings;
};

/// A colourful picture, smooth at any size (a few levels per pixel at most); `phase` tells frames apart.
inline ImageRgb smooth_picture(Size size, int phase = 0) {
  ImageRgb picture(size);
  const auto wave = [](double t) { return static_cast<std::uint8_t>(std::lround(127.5 + 90.0 * std::sin(t))); };
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const double u = (x + 0.5) / std::max(size.width, 64), v = (y + 0.5) / std::max(size.height, 64);
      picture(x, y) = {wave(3 * u + 0.3 * phase), wave(2 * v + 2 * u + 1), wave(3 * v - u + 2 - 0.2 * phase)};
    }
  return picture;
}

/// A grey picture whose level is the frame's number, four levels apart so that lossy coding cannot confuse them.
inline ImageRgb numbered_picture(Size size, int number) {
  const auto level = static_cast<std::uint8_t>(20 + 4 * number);
  return ImageRgb(size, {level, level, level});
}
inline int number_of(const ImageRgb& picture) {
  return static_cast<int>(std::lround((picture(picture.width() / 2, picture.height() / 2).g - 20) / 4.0));
}

/// A clip of numbered pictures (at most 55).
inline std::string write_numbered_clip(const std::string& path, Size size, int frames) {
  VideoWriter writer(path, size);
  for (int i = 0; i < frames; ++i) writer.write(numbered_picture(size, i));
  writer.finish();
  return path;
}

inline ClipOptions whole_clip_unresized() {
  ClipOptions options;
  options.max_frames = 0;
  options.resize.mode = ResizePolicy::Mode::none;
  return options;
}

inline std::vector<ImageRgb> read_all(FrameSource& source) {
  std::vector<ImageRgb> frames;
  ImageRgb frame;
  for (long i = 0; i < source.frames() && source.read(i, frame); ++i) frames.push_back(frame);
  return frames;
}

inline std::vector<ImageRgb> read_all(const std::string& path, const ClipOptions& options = whole_clip_unresized()) {
  Monitor monitor;
  return read_all(*open_clip(path, options, monitor));
}

/// Peak signal-to-noise ratio in dB over all channels.
inline double psnr(const ImageRgb& a, const ImageRgb& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i) {
    const Rgb8 p = a.pixels()[i], q = b.pixels()[i];
    for (const int d : {p.r - q.r, p.g - q.g, p.b - q.b}) sum += d * d;
  }
  return sum == 0 ? HUGE_VAL : 10 * std::log10(255.0 * 255.0 * 3 * static_cast<double>(a.pixels().size()) / sum);
}

/// Mean of a - b per channel, in levels.
inline std::array<double, 3> mean_shift(const ImageRgb& a, const ImageRgb& b) {
  std::array<double, 3> sum{};
  for (std::size_t i = 0; i < a.pixels().size(); ++i) {
    const Rgb8 p = a.pixels()[i], q = b.pixels()[i];
    sum[0] += p.r - q.r;
    sum[1] += p.g - q.g;
    sum[2] += p.b - q.b;
  }
  for (double& s : sum) s /= static_cast<double>(a.pixels().size());
  return sum;
}

/// Whether the ffmpeg program is there to make inputs we cannot write ourselves.
inline bool have_ffmpeg() { return std::system("ffmpeg -version > /dev/null 2>&1") == 0; }

/// Runs ffmpeg with these arguments, quietly; false when it fails.
inline bool ffmpeg(const std::string& arguments) {
  return std::system(("ffmpeg -v quiet -nostdin -y " + arguments + " > /dev/null 2>&1").c_str()) == 0;
}

}  // namespace uwv::test
