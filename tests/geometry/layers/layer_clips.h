// SPDX-License-Identifier: Apache-2.0
// Clips for the layers' tests: a textured disc that moves before a textured wall, with the wall known everywhere.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "uwv/geometry/layers.h"

namespace uwv::layer_clips {

struct Clip {
  std::vector<ImageRgb> frames, walls;
  std::vector<ForegroundMask> masks;
};

struct Motion {
  double speed = 3;     ///< Pixels a frame, to the right, against the wall.
  double growth = 1;    ///< Of the radius, a frame.
  double pan = 0;       ///< Pixels a frame by which wall and disc move together.
  double exposure = 1;  ///< Of brightness, a frame.
};

inline Rgb8 shade(double u, double v, double phase, double r, double g, double b, double gain = 1) {
  const double wave =
      std::sin(0.31 * u + phase) + std::sin(0.23 * v + 0.11 * u) + std::sin(0.17 * u - 0.29 * v + 2 * phase);
  const auto value = [&](double mean) {
    return static_cast<std::uint8_t>(std::clamp(gain * (mean + 14 * wave), 0.0, 255.0));
  };
  return {value(r), value(g), value(b)};
}

inline Clip sprite(Size size, int frames, const Motion& motion) {
  Clip clip;
  for (int i = 0; i < frames; ++i) {
    const double radius = 0.18 * size.height * std::pow(motion.growth, i), gain = std::pow(motion.exposure, i);
    const double cx = 0.25 * size.width + (motion.speed + motion.pan) * i, cy = 0.5 * size.height;
    ImageRgb frame(size), wall(size);
    ForegroundMask mask(size);
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x) {
        const double dx = x + 0.5 - cx, dy = y + 0.5 - cy;
        const bool inside = std::hypot(dx, dy) < radius;
        wall(x, y) = shade(x - motion.pan * i, y, 0, 70, 95, 120, gain);
        frame(x, y) = inside ? shade(dx, dy, 1, 190, 110, 60) : wall(x, y);
        mask(x, y) = inside;
      }
    clip.frames.push_back(std::move(frame));
    clip.walls.push_back(std::move(wall));
    clip.masks.push_back(std::move(mask));
  }
  return clip;
}

/// Intersection over union; 1 when both are empty.
inline double overlap(const ForegroundMask& a, const ForegroundMask& b) {
  double both = 0, either = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i) {
    both += a.data()[i] != 0 && b.data()[i] != 0;
    either += a.data()[i] != 0 || b.data()[i] != 0;
  }
  return either > 0 ? both / either : 1;
}

}  // namespace uwv::layer_clips
