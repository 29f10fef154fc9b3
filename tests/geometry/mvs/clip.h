// SPDX-License-Identifier: Apache-2.0
// Clips of synthetic scenes with everything known, and how far a depth is from the truth.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "uwv/eval/stock_scenes.h"
#include "uwv/geometry/multi_view_stereo.h"

namespace uwv::test {

struct Clip {
  std::vector<ImageRgb> frames;
  std::vector<Camera> cameras;
  std::vector<DepthMap> truth;
  std::vector<ScenePoint> points;
};

/// `count` frames of an orbit of `degrees` in all around the subject, and 400 points taken from the truth.
inline Clip orbit_clip(const StockScene& stock, int count, double degrees, ThreadPool& pool) {
  Clip clip;
  for (int i = 0; i < count; ++i) {
    const double share = count > 1 ? static_cast<double>(i) / (count - 1) - 0.5 : 0.0;
    const Camera camera = orbit_camera(stock.source, stock.subject_in_world, share * degrees * std::numbers::pi / 180);
    SyntheticFrame frame = render(stock.scene, camera, 0, pool, 2);
    clip.frames.push_back(std::move(frame.colour));
    clip.truth.push_back(std::move(frame.depth));
    clip.cameras.push_back(camera);
  }
  std::mt19937 random(7);
  for (int i = 0; i < 400; ++i) {
    const std::size_t f = random() % clip.frames.size();
    const int x = static_cast<int>(random() % static_cast<unsigned>(stock.source.size.width));
    const int y = static_cast<int>(random() % static_cast<unsigned>(stock.source.size.height));
    const float z = clip.truth[f](x, y);
    if (z <= 0) continue;
    ScenePoint point;
    point.x_in_world = clip.cameras[f].world_from_cam * unproject(clip.cameras[f].intrinsics, {x + 0.5, y + 0.5}, z);
    clip.points.push_back(point);
  }
  return clip;
}

inline StockOptions small_scene(Size size = {240, 144}) {
  StockOptions options;
  options.size = size;
  return options;
}

struct DepthError {
  double known = 0;         ///< Share of the pixels that have depth.
  double measured = 0;      ///< Share of the pixels with confidence of 0.5 and more.
  double rel_all = 0;       ///< Mean relative error of what is known.
  double rel_measured = 0;  ///< Of what was measured.
  double rel_filled = 0;    ///< Of the rest.
  double far_off = 0;       ///< Share of the measured that is more than 10% off.
};

inline DepthError error_of(const FrameGeometry& frame, const DepthMap& truth) {
  DepthError out;
  double n[2] = {0, 0}, sum[2] = {0, 0}, off = 0, all = 0;
  for (std::size_t i = 0; i < truth.size().pixels(); ++i) {
    const double z = truth.data()[i];
    if (z <= 0) continue;
    ++all;
    const double d = frame.depth.data()[i];
    if (d <= 0) continue;
    const int k = frame.confidence.data()[i] >= 0.5F ? 1 : 0;
    n[k] += 1;
    sum[k] += std::abs(d - z) / z;
    if (k == 1 && std::abs(d - z) > 0.1 * z) off += 1;
  }
  const auto mean = [](double s, double c) { return c > 0 ? s / c : 0.0; };
  out.known = mean(n[0] + n[1], all);
  out.measured = mean(n[1], all);
  out.rel_all = mean(sum[0] + sum[1], n[0] + n[1]);
  out.rel_measured = mean(sum[1], n[1]);
  out.rel_filled = mean(sum[0], n[0]);
  out.far_off = mean(off, n[1]);
  return out;
}

inline DepthError mean_error(const std::vector<FrameGeometry>& frames, const std::vector<DepthMap>& truth) {
  DepthError out;
  const double n = static_cast<double>(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const DepthError e = error_of(frames[i], truth[i]);
    out.known += e.known / n;
    out.measured += e.measured / n;
    out.rel_all += e.rel_all / n;
    out.rel_measured += e.rel_measured / n;
    out.rel_filled += e.rel_filled / n;
    out.far_off += e.far_off / n;
  }
  return out;
}

/// Whatever the input was: depth is finite, not negative, and goes with a confidence in (0, 1]; 0 goes with 0.
inline bool well_formed(const FrameGeometry& frame, Size size) {
  if (frame.depth.size() != size || frame.confidence.size() != size) return false;
  for (std::size_t i = 0; i < size.pixels(); ++i) {
    const float z = frame.depth.data()[i];
    const float c = frame.confidence.data()[i];
    if (!std::isfinite(z) || z < 0 || !(c >= 0) || c > 1) return false;
    if ((z > 0) != (c > 0)) return false;
  }
  return true;
}

}  // namespace uwv::test
