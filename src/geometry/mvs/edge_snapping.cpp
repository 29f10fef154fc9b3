// SPDX-License-Identifier: Apache-2.0
#include "geometry/mvs/edge_snapping.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace uwv::mvs {
namespace {

constexpr float least_step = 0.05F;  // Between two surfaces, as a share of the farther one's inverse depth.
constexpr int reach = 4;             // Pixels: depth spreads by a window's radius, and smoothness adds to that.
constexpr int radius = 6;            // Of the window; must be more than the reach, to see beyond what has spread.
constexpr float colour_levels = 10;  // Mean difference of the channels at which likeness has fallen to 1/e.
constexpr std::size_t bins = 32;

bool apart(float a, float b) { return a > 0 && b > 0 && std::abs(a - b) > least_step * std::min(a, b); }

/// 1 = at most `reach` pixels from a step, along rows and columns.
Image<std::uint8_t> near_steps(const InverseDepthMap& w) {
  const int width = w.width(), height = w.height();
  Image<std::uint8_t> along_rows(w.size());
  Image<std::uint8_t> near(w.size());
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const bool stepped =
          (x + 1 < width && apart(w(x, y), w(x + 1, y))) || (y + 1 < height && apart(w(x, y), w(x, y + 1)));
      if (!stepped) continue;
      std::uint8_t* row = along_rows.row(y);
      std::fill(row + std::max(x - reach + 1, 0), row + std::min(x + reach + 1, width), std::uint8_t{1});
    }
  for (int y = 0; y < height; ++y)
    for (int v = std::max(y - reach, 0); v < std::min(y + reach, height); ++v)
      for (int x = 0; x < width; ++x) near(x, y) = static_cast<std::uint8_t>(near(x, y) | along_rows(x, v));
  return near;
}

constexpr std::size_t differences = 3 * 255 + 1;  // Of two colours, summed over the channels.

std::array<float, differences> likeness_table() {
  std::array<float, differences> table{};
  for (std::size_t i = 0; i < table.size(); ++i) table[i] = std::exp(-static_cast<float>(i) / (3 * colour_levels));
  return table;
}

class ColourMedian {
 public:
  ColourMedian(const ImageRgb& colour, const InverseDepthMap& depth) : colour_(colour), depth_(depth) {}

  /// Of a pixel whose depth is known.
  float at(int x, int y) const {
    float least = depth_(x, y), most = least;
    for_window(x, y, [&](int u, int v) {
      const float w = depth_(u, v);
      if (w <= 0) return;
      least = std::min(least, w);
      most = std::max(most, w);
    });
    if (!apart(least, most)) return depth_(x, y);
    std::array<float, bins> weights{}, sums{};
    const float bins_per_depth = (static_cast<float>(bins) - 0.01F) / (most - least);
    float total = 0;
    for_window(x, y, [&](int u, int v) {
      const float w = depth_(u, v);
      if (w <= 0) return;
      const float weight = likeness(colour_(x, y), colour_(u, v));
      const std::size_t bin = std::min(bins - 1, static_cast<std::size_t>((w - least) * bins_per_depth));
      weights[bin] += weight;
      sums[bin] += weight * w;
      total += weight;
    });
    std::size_t bin = 0;
    for (float passed = weights[0]; bin + 1 < bins && passed < 0.5F * total;) passed += weights[++bin];
    return sums[bin] / weights[bin];  // The pixel itself is in the window: the total, and so this weight, is not 0.
  }

 private:
  float likeness(const Rgb8& a, const Rgb8& b) const {
    return likeness_[static_cast<std::size_t>(std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b))];
  }

  /// Every second pixel of the window, as on a chessboard, which tells nearly as much; the middle one is among them.
  template <class Body>
  void for_window(int x, int y, const Body& body) const {
    const int right = std::min(x + radius, depth_.width() - 1);
    for (int v = std::max(y - radius, 0); v <= std::min(y + radius, depth_.height() - 1); ++v) {
      const int left = std::max(x - radius, 0);
      for (int u = left + std::abs(x - left + y - v) % 2; u <= right; u += 2) body(u, v);
    }
  }

  const ImageRgb& colour_;
  const InverseDepthMap& depth_;
  std::array<float, differences> likeness_ = likeness_table();
};

}  // namespace

void snap_to_edges(const ImageRgb& colour, InverseDepthMap& inverse_depth) {
  require(colour.size() == inverse_depth.size(), "colour is {}x{}, depth {}x{}", colour.width(), colour.height(),
          inverse_depth.width(), inverse_depth.height());
  const InverseDepthMap before = inverse_depth;
  const Image<std::uint8_t> near = near_steps(before);
  const ColourMedian median(colour, before);
  for (int y = 0; y < before.height(); ++y) {
    for (int x = 0; x < before.width(); ++x) {
      if (near(x, y) == 0 || before(x, y) <= 0) continue;
      const float around = median.at(x, y);
      if (apart(around, before(x, y))) inverse_depth(x, y) = around;
    }
  }
}

}  // namespace uwv::mvs
