// SPDX-License-Identifier: Apache-2.0
// The reference's masks contain rounding noise: a point a hair beside a pixel's centre also marks the neighbour, with a
// weight of 1e-7 or less. Frames whose target is the source camera consist of such points only. Ours land exactly, so
// every mask is made twice: without noise, and with all the noise there can be (points moved by 1e-4 pixels in four
// directions). The golden mask must lie between the two, be equal where they are equal, and that must be nearly
// everywhere.
#pragma once

#include "support/fixture_tensors.h"

namespace uwv::testing {

/// A mask without rounding noise and with all of it; least <= most.
struct Bounds {
  ValidityMask least, most;
};

inline void intersect(Bounds& a, const Bounds& b) {
  uwv::intersect(a.least, b.least);
  uwv::intersect(a.most, b.most);
}
inline void intersect(Bounds& a, const ValidityMask& b) { intersect(a, Bounds{b, b}); }
inline void unite(ValidityMask& a, const ValidityMask& b) {
  for (std::size_t p = 0; p < a.size().pixels(); ++p) a.data()[p] |= b.data()[p];
}

/// Where the points land, given which may.
inline Bounds landing_bounds(Rasterizer& rasterizer, PointGrid points, const Bounds& keep, const Camera& target) {
  const auto valid_from = [&](const Camera& camera) {
    SoftSplat out;
    rasterizer.soft_splat(points, nullptr, camera, {}, out);
    return out.valid;
  };
  points.keep = &keep.least;
  Bounds bounds{valid_from(target), {}};
  points.keep = &keep.most;
  bounds.most = valid_from(target);
  for (const double dx : {-1e-4, 1e-4})
    for (const double dy : {-1e-4, 1e-4}) {
      Camera moved = target;
      moved.intrinsics.cx += dx;
      moved.intrinsics.cy += dy;
      unite(bounds.most, valid_from(moved));
    }
  return bounds;
}

/// Counts over all frames of a file.
struct BoundsTally {
  std::size_t outside = 0, certain = 0, stable = 0;
  void add(const Bounds& ours, const ValidityMask& golden, const ValidityMask& stable_mask) {
    for (std::size_t p = 0; p < golden.size().pixels(); ++p) {
      if (stable_mask.data()[p] == 0) continue;
      ++stable;
      certain += ours.least.data()[p] == ours.most.data()[p];
      outside += golden.data()[p] < ours.least.data()[p] || golden.data()[p] > ours.most.data()[p];
    }
  }
  void expect_good() const {
    EXPECT_EQ(outside, 0U) << "stable pixels outside what rounding can explain";
    EXPECT_GE(static_cast<double>(certain), 0.97 * static_cast<double>(stable));
  }
};

}  // namespace uwv::testing
