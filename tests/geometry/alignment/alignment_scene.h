// SPDX-License-Identifier: Apache-2.0
// Frames whose line is known: a ball before a wall, its relative depth made from the true one.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "uwv/eval/stock_scenes.h"
#include "uwv/geometry/depth_alignment.h"

namespace uwv::testing {

/// The reference depth of a stock scene, times `unit`.
inline DepthMap ball_depth(double unit = 1, Size size = {96, 64}) {
  StockOptions options;
  options.size = size;
  const StockScene stock = sphere_floor_wall(options);
  ThreadPool pool(1);
  DepthMap depth = render(stock.scene, stock.source, 0, pool).depth;
  for (float& z : depth.pixels()) z = static_cast<float>(static_cast<double>(z) * unit);
  return depth;
}

/// v such that 1/D = line(v).
inline Image<float> relative_inverse(const DepthMap& depth, const AlignmentLine& line) {
  Image<float> v(depth.size());
  for (std::size_t p = 0; p < v.pixels().size(); ++p)
    v.pixels()[p] = static_cast<float>((1 / static_cast<double>(depth.pixels()[p]) - line.shift) / line.scale);
  return v;
}

/// Multiplies depth by exp(normal noise).
inline void add_noise(DepthMap& depth, double deviation, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, deviation);
  for (float& z : depth.pixels()) z = static_cast<float>(static_cast<double>(z) * std::exp(noise(random)));
}

/// Replaces a share of the depths by anything between `low` and `high` times as deep as the nearest one.
inline void add_outliers(DepthMap& depth, double share, double low, double high, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  const float nearest = *std::min_element(depth.pixels().begin(), depth.pixels().end());
  for (float& z : depth.pixels())
    if (unit(random) < share)
      z = static_cast<float>(static_cast<double>(nearest) * (low + (high - low) * unit(random)));
}

/// Pictures and the frame that points to them.
struct Clip {
  std::vector<DepthMap> references;
  std::vector<Image<float>> relatives;
  std::vector<ValidityMask> masks;
  std::vector<AlignmentFrame> frames() const {
    std::vector<AlignmentFrame> out;
    for (std::size_t i = 0; i < references.size(); ++i)
      out.push_back({&relatives[i], &references[i], masks.empty() ? nullptr : &masks[i], nullptr});
    return out;
  }
};

inline AlignmentSummary align(const Clip& clip, const AlignmentOptions& options, int threads = 1) {
  ThreadPool pool(threads);
  Monitor monitor;
  return align_depth(clip.frames(), options, pool, monitor);
}

inline FrameAlignment align_one(const Image<float>& relative, const DepthMap& reference,
                                const AlignmentOptions& options, const ValidityMask* mask = nullptr,
                                const Image<float>* weights = nullptr) {
  DepthAligner aligner(options);
  aligner.add({&relative, &reference, mask, weights});
  return aligner.finish().frames.front();
}

}  // namespace uwv::testing
