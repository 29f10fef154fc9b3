// SPDX-License-Identifier: Apache-2.0
// The samples of a frame: pairs of numbers with a weight.
#pragma once

#include <cmath>
#include <vector>

#include "uwv/geometry/depth_alignment.h"

namespace uwv::alignment {

struct Sample {
  double x = 0, y = 0;  ///< y is wanted to be a line of x.
  double weight = 1;    ///< In (0, 1], the largest being 1.
  /// What losses count residuals in: y itself, the noise of depth growing with depth. In absolute terms wrong samples
  /// far away, where inverse depths crowd, would look as if they agreed on a flat line.
  double unit() const { return y; }
};
using Samples = std::vector<Sample>;

inline bool has_shift(AlignmentModel model) {
  return model == AlignmentModel::inverse_affine || model == AlignmentModel::depth_affine;
}
inline bool of_inverse(AlignmentModel model) {
  return model == AlignmentModel::inverse_affine || model == AlignmentModel::inverse_scale;
}
inline double residual(const AlignmentLine& line, const Sample& s) { return line.scale * s.x + line.shift - s.y; }
inline double relative_residual(const AlignmentLine& line, const Sample& s) { return residual(line, s) / s.unit(); }

/// Weighted means and centred second moments: all that squares need to know of samples.
struct Moments {
  double weight = 0;
  double mean_x = 0, mean_y = 0;
  double xx = 0, xy = 0, yy = 0;  ///< Weighted means of products of differences from the means.
};

/// `extra(sample)` multiplies a sample's weight. Two passes: differences are taken before they are squared.
template <class Extra>
Moments moments_of(const Samples& samples, const Extra& extra) {
  Moments m;
  for (const Sample& s : samples) {
    const double w = s.weight * extra(s);
    m.weight += w;
    m.mean_x += w * s.x;
    m.mean_y += w * s.y;
  }
  if (!(m.weight > 0)) return {};
  m.mean_x /= m.weight;
  m.mean_y /= m.weight;
  for (const Sample& s : samples) {
    const double w = s.weight * extra(s) / m.weight, dx = s.x - m.mean_x, dy = s.y - m.mean_y;
    m.xx += w * dx * dx;
    m.xy += w * dx * dy;
    m.yy += w * dy * dy;
  }
  return m;
}
inline Moments moments_of(const Samples& samples) {
  return moments_of(samples, [](const Sample&) { return 1.0; });
}

/// All samples lie at one x or at one y, as far as float pictures can tell.
inline bool is_singular(const Moments& m, bool shift) {
  constexpr double rounding = 1e-6;  // a few units in the last place of float
  if (!shift) return false;
  return std::sqrt(m.xx) <= rounding * std::fabs(m.mean_x) || std::sqrt(m.yy) <= rounding * std::fabs(m.mean_y);
}

/// Every pixel of a frame that can be a sample, in row order. Throws std::invalid_argument for pictures that don't fit.
Samples candidates_of(const AlignmentFrame& frame, const AlignmentOptions& options);

/// Keeps `share` of the samples (rounded down, but at least `min_samples` of them), drawn with `seed`, in their order.
void draw(Samples& samples, double share, std::size_t at_least, std::uint64_t seed);

/// A seed of a frame's own.
std::uint64_t mixed(std::uint64_t seed, std::uint64_t frame);

}  // namespace uwv::alignment
