// SPDX-License-Identifier: Apache-2.0
// A clip with a hole, completed by the model, and how near two results are.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "uwv/model/view_completion.h"

namespace uwv::bench {

/// A pattern that drifts, and a hole that grows from the right.
inline RenderedClip moving_pattern(Size size, long frames) {
  const auto picture = [size](long k) {
    ImageRgb colour(size);
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x) {
        const auto wave = [&](double period, double phase) {
          const double at = (x + 2.0 * static_cast<double>(k)) / period + phase + y / 9.0;
          return static_cast<std::uint8_t>(127.5 + 100 * std::sin(at * 2 * std::numbers::pi));
        };
        colour(x, y) = {wave(23, 0), wave(31, 0.3), wave(41, 0.6)};
      }
    return colour;
  };
  RenderedClip clip{size, frames, {}, [picture](long k, ImageRgb& colour) { colour = picture(k); }};
  clip.read = [picture, size, frames](long k, ImageRgb& colour, GenerateMask& holes) {
    colour = picture(k);
    holes = GenerateMask(size.width, size.height);
    const long edge = size.width - size.width * k / (2 * frames);
    for (int y = 0; y < size.height; ++y)
      for (long x = edge; x < size.width; ++x) {
        holes(static_cast<int>(x), y) = 1;
        colour(static_cast<int>(x), y) = {};
      }
  };
  return clip;
}

struct Completed {
  std::vector<ImageRgb> frames;
  CompletionSummary summary;
};

inline Completed complete(const ModelOptions& options, const RenderedClip& clip, int threads) {
  Completed done;
  Monitor monitor;
  CompletedClip out;
  out.write = [&](long, const ImageRgb& frame) { done.frames.push_back(frame); };
  done.summary = complete_views(options, clip, out, threads, monitor);
  return done;
}

inline double psnr(const std::vector<ImageRgb>& a, const std::vector<ImageRgb>& b) {
  double sum = 0, values = 0;
  for (std::size_t k = 0; k < a.size(); ++k)
    for (std::size_t i = 0; i < a[k].size().pixels(); ++i) {
      const Rgb8 p = a[k].data()[i], q = b[k].data()[i];
      for (const int difference : {p.r - q.r, p.g - q.g, p.b - q.b}) sum += difference * difference;
      values += 3;
    }
  return sum == 0 ? 99 : std::min(99.0, 10 * std::log10(255 * 255 * values / sum));
}

}  // namespace uwv::bench
