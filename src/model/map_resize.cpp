// SPDX-License-Identifier: Apache-2.0
#include "model/map_resize.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace uwv::model {
namespace {

/// The two source pixels a target pixel lies between, and how far it is towards the second.
struct Between {
  int first, second, nearest;
  float part;
};

std::vector<Between> betweens(int from, int to) {
  std::vector<Between> all(static_cast<std::size_t>(to));
  const double scale = static_cast<double>(from) / to;
  for (int i = 0; i < to; ++i) {
    const double at = std::clamp((i + 0.5) * scale - 0.5, 0.0, from - 1.0);
    const int first = std::min(static_cast<int>(at), from - 1);
    const int second = std::min(first + 1, from - 1);
    const auto part = static_cast<float>(at - first);
    all[static_cast<std::size_t>(i)] = {first, second, part < 0.5F ? first : second, part};
  }
  return all;
}

/// Calls pixel(x, y, nearest x, nearest y, four source places, four weights) for every target pixel.
template <class Pixel>
void for_each_target(Size from, Size to, const Pixel& pixel) {
  const auto columns = betweens(from.width, to.width), rows = betweens(from.height, to.height);
  for (int y = 0; y < to.height; ++y) {
    const Between& row = rows[static_cast<std::size_t>(y)];
    for (int x = 0; x < to.width; ++x) {
      const Between& column = columns[static_cast<std::size_t>(x)];
      const int xs[4] = {column.first, column.second, column.first, column.second};
      const int ys[4] = {row.first, row.first, row.second, row.second};
      const float weights[4] = {(1 - column.part) * (1 - row.part), column.part * (1 - row.part),
                                (1 - column.part) * row.part, column.part * row.part};
      pixel(x, y, column.nearest, row.nearest, xs, ys, weights);
    }
  }
}

}  // namespace

KnownMap resized(const KnownMap& map, Size size) {
  if (map.value.size() == size) return map;
  KnownMap out{FloatMap(size), FloatMap(size)};
  for_each_target(map.value.size(), size,
                  [&](int x, int y, int near_x, int near_y, const int* xs, const int* ys, const float* weights) {
                    if (!(map.confidence(near_x, near_y) > 0)) return;
                    double value = 0, confidence = 0, sum = 0;
                    for (int i = 0; i < 4; ++i) {
                      const float known = map.confidence(xs[i], ys[i]);
                      if (!(known > 0)) continue;
                      const double weight = weights[i];
                      value += weight * map.value(xs[i], ys[i]);
                      confidence += weight * known;
                      sum += weight;
                    }
                    out.value(x, y) = static_cast<float>(value / sum);
                    out.confidence(x, y) = static_cast<float>(confidence / sum);
                  });
  return out;
}

VectorMap resized_directions(const VectorMap& map, Size size) {
  VectorMap out(size);
  for_each_target(map.size(), size,
                  [&](int x, int y, int near_x, int near_y, const int* xs, const int* ys, const float* weights) {
                    if (map(near_x, near_y).isZero()) return;
                    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
                    for (int i = 0; i < 4; ++i) sum += weights[i] * map(xs[i], ys[i]);
                    out(x, y) = sum.squaredNorm() > 1e-12F ? Eigen::Vector3f(sum.normalized()) : map(near_x, near_y);
                  });
  return out;
}

}  // namespace uwv::model
