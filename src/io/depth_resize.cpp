// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <vector>

#include "uwv/core/depth.h"
#include "uwv/io/depth_source.h"

namespace uwv {
namespace {

constexpr float same_surface = 0.05F;

/// Where one coordinate of the new picture lies in the old one.
struct Sample {
  int low = 0, high = 0;  // neighbours around it, clamped to the picture
  int nearest = 0;
  float share = 0;  // of `high`
};

std::vector<Sample> samples(int from, int to) {
  std::vector<Sample> result(static_cast<std::size_t>(to));
  for (int i = 0; i < to; ++i) {
    const double at = (i + 0.5) * from / to;  // measured from the picture's edge
    const double below = std::floor(at - 0.5);
    Sample& sample = result[static_cast<std::size_t>(i)];
    sample.low = std::clamp(static_cast<int>(below), 0, from - 1);
    sample.high = std::clamp(static_cast<int>(below) + 1, 0, from - 1);
    sample.nearest = std::min(static_cast<int>(at), from - 1);
    sample.share = static_cast<float>(at - 0.5 - below);
  }
  return result;
}

float sample_depth(const float* low_row, const float* high_row, const Sample& x, const Sample& y, float nearest) {
  const float a = low_row[x.low], b = low_row[x.high], c = high_row[x.low], d = high_row[x.high];
  const auto [min, max] = std::minmax({a, b, c, d});
  if (!is_valid_depth(min) || !is_valid_depth(max) || max - min > same_surface * min) return nearest;
  if (min == max) return min;
  const float top = (1 - x.share) / a + x.share / b;
  const float bottom = (1 - x.share) / c + x.share / d;
  return std::clamp(1 / ((1 - y.share) * top + y.share * bottom), min, max);
}

}  // namespace

DepthMap resize_depth(const DepthMap& depth, Size size) {
  require(!depth.empty() && size.width > 0 && size.height > 0, "depth cannot be resized from {}x{} to {}x{}",
          depth.width(), depth.height(), size.width, size.height);
  if (depth.size() == size) return depth;
  const std::vector<Sample> xs = samples(depth.width(), size.width), ys = samples(depth.height(), size.height);
  DepthMap out(size);
  for (int row = 0; row < size.height; ++row) {
    const Sample& y = ys[static_cast<std::size_t>(row)];
    const float* nearest_row = depth.row(y.nearest);
    for (int column = 0; column < size.width; ++column) {
      const Sample& x = xs[static_cast<std::size_t>(column)];
      out(column, row) = sample_depth(depth.row(y.low), depth.row(y.high), x, y, nearest_row[x.nearest]);
    }
  }
  return out;
}

}  // namespace uwv
