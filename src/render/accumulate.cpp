// SPDX-License-Identifier: Apache-2.0
#include "render/accumulate.h"

namespace uwv::detail {
namespace {

/// 1 for points whose centre does not land inside the target's picture.
ValidityMask out_of_view(const PointGrid& points, const Camera& target, ThreadPool& pool) {
  const WarpMap map = WarpMap::between(points.camera, target);
  ValidityMask outside(points.camera.size);
  const float width = static_cast<float>(target.size.width), height = static_cast<float>(target.size.height);
  pool.for_ranges(0, outside.height(), 16, [&](int from, int to) {
    for (int y = from; y < to; ++y)
      for (int x = 0; x < outside.width(); ++x) {
        const float z = (*points.depth)(x, y);
        const auto row = [&](std::size_t i) {
          return z * (map.a[i][0] * static_cast<float>(x) + (map.a[i][1] * static_cast<float>(y) + map.a[i][2])) +
                 map.b[i];
        };
        const float p2 = row(2), u = row(0) / p2, v = row(1) / p2;
        outside(x, y) = !(p2 > 0 && u >= 0 && v >= 0 && u < width && v < height);
      }
  });
  return outside;
}

void unite(ValidityMask& a, const ValidityMask& b) {
  std::transform(a.pixels().begin(), a.pixels().end(), b.pixels().begin(), a.pixels().begin(),
                 [](std::uint8_t x, std::uint8_t y) { return static_cast<std::uint8_t>(x | y); });
}

}  // namespace

void VisibleSoFar::add(const ValidityMask& second, const PointGrid& points, const Camera& target,
                       const ValidityMask* foreground, ThreadPool& pool) {
  require(visible_.empty() || visible_.size() == second.size(),
          "the source's size changed from {}x{} to {}x{} along the path; call restart() first", visible_.width(),
          visible_.height(), second.width(), second.height());
  if (rule_ == Accumulation::none || visible_.empty()) {
    visible_ = second;
    if (rule_ == Accumulation::product_in_view) unite(visible_, out_of_view(points, target, pool));
  } else if (rule_ == Accumulation::product_in_view) {
    ValidityMask seen = out_of_view(points, target, pool);
    unite(seen, second);
    intersect(visible_, seen);
  } else {
    intersect(visible_, second);
  }
  if (rule_ == Accumulation::foreground && foreground != nullptr) unite(visible_, *foreground);
}

void VisibleSoFar::add_all(Size size, const ValidityMask* foreground) {
  if (rule_ == Accumulation::none || visible_.empty()) visible_ = ValidityMask(size, 1);
  if (rule_ == Accumulation::foreground && foreground != nullptr) unite(visible_, *foreground);
}

}  // namespace uwv::detail
