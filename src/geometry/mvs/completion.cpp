// SPDX-License-Identifier: Apache-2.0
#include "geometry/mvs/completion.h"

#include <algorithm>
#include <cmath>

namespace uwv::mvs {
namespace {

constexpr float edge_levels = 3;         // Colour difference that makes smoothness e times weaker.
constexpr float least_weight = 0.0005F;  // Across the strongest edge something still connects: every pixel gets filled.
constexpr int sweeps = 12;               // Per level; coarser levels have brought what is smooth.
constexpr float relaxation = 1.7F;
constexpr float fill_confidence = 0.4F;

float difference(const Rgb8& a, const Rgb8& b) {
  return (static_cast<float>(std::abs(a.r - b.r)) + static_cast<float>(std::abs(a.g - b.g)) +
          static_cast<float>(std::abs(a.b - b.b))) *
         (1 / 3.0F);
}

float likeness(const Rgb8& a, const Rgb8& b) {
  return std::max(least_weight, std::exp(-difference(a, b) / edge_levels));
}

struct Level {
  ImageRgb colour;
  Image<float> value;         ///< Inverse depth.
  Image<std::uint8_t> known;  ///< 1 = value is measured and stays.
};

/// Half the size; a coarse pixel is known where one of its four is, as the mean of those.
Level coarser(const Level& fine) {
  const Size size{(fine.value.width() + 1) / 2, (fine.value.height() + 1) / 2};
  Level out{ImageRgb(size), Image<float>(size), Image<std::uint8_t>(size)};
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      int r = 0, g = 0, b = 0, n = 0, known = 0;
      float sum = 0;
      for (int v = 2 * y; v < std::min(2 * y + 2, fine.value.height()); ++v) {
        for (int u = 2 * x; u < std::min(2 * x + 2, fine.value.width()); ++u) {
          const Rgb8& c = fine.colour(u, v);
          r += c.r, g += c.g, b += c.b, ++n;
          if (fine.known(u, v) == 0) continue;
          sum += fine.value(u, v);
          ++known;
        }
      }
      out.colour(x, y) = {static_cast<std::uint8_t>(r / n), static_cast<std::uint8_t>(g / n),
                          static_cast<std::uint8_t>(b / n)};
      out.known(x, y) = known > 0 ? 1 : 0;
      out.value(x, y) = known > 0 ? sum / static_cast<float>(known) : 0.0F;
    }
  }
  return out;
}

/// Successive over-relaxation of the unknown pixels, row by row.
void relax(Level& level) {
  const int width = level.value.width();
  const int height = level.value.height();
  Image<float> right(level.value.size());
  Image<float> below(level.value.size());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (x + 1 < width) right(x, y) = likeness(level.colour(x, y), level.colour(x + 1, y));
      if (y + 1 < height) below(x, y) = likeness(level.colour(x, y), level.colour(x, y + 1));
    }
  }
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    const bool back = sweep % 2 != 0;
    for (int i = 0; i < width * height; ++i) {
      const int at = back ? width * height - 1 - i : i;
      const int x = at % width;
      const int y = at / width;
      if (level.known(x, y) != 0) continue;
      float sum = 0;
      float weight = 0;
      const auto add = [&](float w, float value) {
        sum += w * value;
        weight += w;
      };
      if (x > 0) add(right(x - 1, y), level.value(x - 1, y));
      if (x + 1 < width) add(right(x, y), level.value(x + 1, y));
      if (y > 0) add(below(x, y - 1), level.value(x, y - 1));
      if (y + 1 < height) add(below(x, y), level.value(x, y + 1));
      if (weight > 0) level.value(x, y) += relaxation * (sum / weight - level.value(x, y));
    }
  }
}

void solve(Level& level) {
  const bool all_known =
      std::all_of(level.known.pixels().begin(), level.known.pixels().end(), [](std::uint8_t k) { return k != 0; });
  if (all_known) return;
  if (level.value.width() > 1 || level.value.height() > 1) {
    Level coarse = coarser(level);
    solve(coarse);
    for (int y = 0; y < level.value.height(); ++y)
      for (int x = 0; x < level.value.width(); ++x)
        if (level.known(x, y) == 0) level.value(x, y) = coarse.value(x / 2, y / 2);
    relax(level);
  }
}

}  // namespace

void complete(const View& view, RatedDepth& depth) {
  const Size size = depth.inverse_depth.size();
  Level level{view.colour, depth.inverse_depth, Image<std::uint8_t>(size)};
  float least = 0;
  float most = 0;
  for (std::size_t i = 0; i < size.pixels(); ++i) {
    const float w = level.value.data()[i];
    if (w <= 0) continue;
    level.known.data()[i] = 1;
    least = least > 0 ? std::min(least, w) : w;
    most = std::max(most, w);
  }
  if (most <= 0) return;
  solve(level);
  for (std::size_t i = 0; i < size.pixels(); ++i) {
    if (level.known.data()[i] != 0) continue;
    // Over-relaxation may overshoot what was measured; the smoothest filling never does.
    depth.inverse_depth.data()[i] = std::clamp(level.value.data()[i], least, most);
    depth.confidence.data()[i] = fill_confidence;
  }
}

RatedDepth upsample(const View& view, const RatedDepth& depth, const ImageRgb& frame, double tolerance) {
  if (frame.size() == depth.inverse_depth.size()) return depth;
  RatedDepth out{InverseDepthMap(frame.size()), Image<float>(frame.size())};
  const Size coarse = depth.inverse_depth.size();
  const float fx = static_cast<float>(coarse.width) / static_cast<float>(frame.width());
  const float fy = static_cast<float>(coarse.height) / static_cast<float>(frame.height());
  const auto limit = static_cast<float>(tolerance);
  for (int y = 0; y < frame.height(); ++y) {
    const float cv =
        std::clamp((static_cast<float>(y) + 0.5F) * fy - 0.5F, 0.0F, static_cast<float>(coarse.height - 1));
    const int v0 = static_cast<int>(cv);
    const float tv = cv - static_cast<float>(v0);
    for (int x = 0; x < frame.width(); ++x) {
      const float cu =
          std::clamp((static_cast<float>(x) + 0.5F) * fx - 0.5F, 0.0F, static_cast<float>(coarse.width - 1));
      const int u0 = static_cast<int>(cu);
      const float tu = cu - static_cast<float>(u0);
      float weights[4], values[4], confidences[4];
      int best = 0;
      for (int k = 0; k < 4; ++k) {
        const int u = std::min(u0 + k % 2, coarse.width - 1);
        const int v = std::min(v0 + k / 2, coarse.height - 1);
        values[k] = depth.inverse_depth(u, v);
        confidences[k] = depth.confidence(u, v);
        const float near = (k % 2 != 0 ? tu : 1 - tu) * (k / 2 != 0 ? tv : 1 - tv);
        weights[k] = values[k] > 0 ? near * likeness(frame(x, y), view.colour(u, v)) : 0.0F;
        if (weights[k] > weights[best]) best = k;
      }
      if (weights[best] <= 0) continue;
      float sum = 0, total = 0;
      for (int k = 0; k < 4; ++k) {
        if (std::abs(values[k] - values[best]) > limit * values[best]) continue;
        sum += weights[k] * values[k];
        total += weights[k];
      }
      out.inverse_depth(x, y) = sum / total;
      out.confidence(x, y) = confidences[best];
    }
  }
  return out;
}

}  // namespace uwv::mvs
