// SPDX-License-Identifier: Apache-2.0
#include "render/accumulate.h"

namespace uwv::detail {
namespace {

/// 1 for points whose centre does not land inside the target's picture.
ValidityMask out_of_view(const PointGrid& points, const Camera& target, ThreadPool& pool) {
  const WarpMap map = WarpMap::between(points.camera, target);
  ValidityMask outside(points.camera.size);
  pool.for_ranges(0, outside.height(), 16, [&](int from, int to) {
    for (int y = from; y < to; ++y)
      for (int x = 0; x < outside.width(); ++x)
        outside(x, y) = !map.apply(x, y, (*points.depth)(x, y)).inside(target.size);
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
