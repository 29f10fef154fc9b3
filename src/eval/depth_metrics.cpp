// SPDX-License-Identifier: Apache-2.0
#include "uwv/eval/depth_metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "uwv/core/depth.h"

namespace uwv {
namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

struct Pair {
  double estimate = 0, truth = 0;
};

double median_ratio(const std::vector<Pair>& pairs) {
  std::vector<double> ratios(pairs.size());
  std::transform(pairs.begin(), pairs.end(), ratios.begin(), [](const Pair& p) { return p.truth / p.estimate; });
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  return *middle;
}

/// The least-squares line from 1/estimate to 1/truth; false when the estimates are all alike.
bool inverse_line(const std::vector<Pair>& pairs, double& scale, double& shift) {
  const double n = static_cast<double>(pairs.size());
  double x = 0, y = 0, xx = 0, xy = 0;
  for (const Pair& p : pairs) {
    x += 1 / p.estimate / n;
    y += 1 / p.truth / n;
  }
  for (const Pair& p : pairs) {
    const double dx = 1 / p.estimate - x;
    xx += dx * dx / n;
    xy += dx * (1 / p.truth - y) / n;
  }
  if (!(std::sqrt(xx) > 1e-6 * x)) return false;
  scale = xy / xx;
  shift = y - scale * x;
  return true;
}

/// Applies what is forgiven and drops what that puts behind infinity.
void forgive(std::vector<Pair>& pairs, DepthFit fit, DepthErrors& errors) {
  if (pairs.empty() || fit == DepthFit::none) return;
  if (fit == DepthFit::scale_shift && inverse_line(pairs, errors.scale, errors.shift)) {
    for (Pair& p : pairs) p.estimate = 1 / (errors.scale / p.estimate + errors.shift);
    std::erase_if(pairs, [](const Pair& p) { return !(p.estimate > 0) || !std::isfinite(p.estimate); });
    return;
  }
  errors.scale = median_ratio(pairs);
  for (Pair& p : pairs) p.estimate *= errors.scale;
}

bool edge_between(float near, float far, double ratio) {
  return is_valid_depth(near) && is_valid_depth(far) &&
         static_cast<double>(far) - static_cast<double>(near) > ratio * static_cast<double>(near);
}

ValidityMask edges_of(const DepthMap& depth, double ratio, const ValidityMask& judged) {
  ValidityMask edges(depth.size());
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 0; x < depth.width(); ++x) {
      if (judged(x, y) == 0) continue;
      const auto steps_to = [&](int u, int v) {
        return depth.contains(u, v) && judged(u, v) != 0 && edge_between(depth(x, y), depth(u, v), ratio);
      };
      edges(x, y) = steps_to(x - 1, y) || steps_to(x + 1, y) || steps_to(x, y - 1) || steps_to(x, y + 1);
    }
  return edges;
}

ValidityMask judged_pixels(const DepthMap& truth, const ValidityMask* mask) {
  ValidityMask judged(truth.size());
  for (std::size_t p = 0; p < truth.pixels().size(); ++p)
    judged.pixels()[p] = is_valid_depth(truth.pixels()[p]) && (mask == nullptr || mask->pixels()[p] != 0);
  return judged;
}

double harmonic_mean(const DepthEdgeScore& score) {
  if (score.estimated == 0 && score.true_edges == 0) return 1;
  const double sum = score.precision + score.recall;  // NaN when either has no edges
  return sum > 0 ? 2 * score.precision * score.recall / sum : 0;
}

/// Share of `edges` with one of `others` close by.
double found_share(const ValidityMask& edges, const ValidityMask& others, int tolerance, std::size_t& count) {
  std::size_t found = 0;
  count = 0;
  for (int y = 0; y < edges.height(); ++y)
    for (int x = 0; x < edges.width(); ++x) {
      if (edges(x, y) == 0) continue;
      ++count;
      bool close = false;
      for (int v = std::max(0, y - tolerance); v <= std::min(edges.height() - 1, y + tolerance) && !close; ++v)
        for (int u = std::max(0, x - tolerance); u <= std::min(edges.width() - 1, x + tolerance) && !close; ++u)
          close = others(u, v) != 0;
      found += close;
    }
  return count > 0 ? static_cast<double>(found) / static_cast<double>(count) : nothing;
}

/// Depth at a point of the picture, between pixel centres; 0 beside an edge, an invalid depth or the border. Inverse
/// depth is linear on planes.
double depth_at(const DepthMap& depth, const Eigen::Vector2d& pixel) {
  constexpr double edge = 0.1;
  const double u = pixel.x() - 0.5, v = pixel.y() - 0.5;
  if (!(u >= 0 && v >= 0 && u <= depth.width() - 1 && v <= depth.height() - 1)) return 0;
  const int x = std::min(static_cast<int>(u), std::max(0, depth.width() - 2));
  const int y = std::min(static_cast<int>(v), std::max(0, depth.height() - 2));
  const int right = std::min(x + 1, depth.width() - 1), below = std::min(y + 1, depth.height() - 1);
  const float corners[4] = {depth(x, y), depth(right, y), depth(x, below), depth(right, below)};
  const auto [nearest, farthest] = std::minmax_element(corners, corners + 4);
  if (!is_valid_depth(*nearest) || edge_between(*nearest, *farthest, edge)) return 0;
  const double s = u - x, t = v - y;
  const auto inverse = [&](int i) { return 1 / static_cast<double>(corners[i]); };
  return 1 / ((1 - t) * ((1 - s) * inverse(0) + s * inverse(1)) + t * ((1 - s) * inverse(2) + s * inverse(3)));
}

/// Sums over pairs of frames; means at the end.
class FlickerSum {
 public:
  explicit FlickerSum(const FlickerOptions& options) : options_(options) {}

  void add(const DepthMap& from, const Camera& here, const DepthMap& to, const Camera& there,
           const ValidityMask* at_rest) {
    const Rigid3 motion = target_from_source(there, here);
    for (int y = 0; y < from.height(); ++y)
      for (int x = 0; x < from.width(); ++x) {
        if (!is_valid_depth(from(x, y)) || (at_rest != nullptr && (*at_rest)(x, y) == 0)) continue;
        const Eigen::Vector3d x_in_there =
            motion * unproject(here.intrinsics, {x + 0.5, y + 0.5}, static_cast<double>(from(x, y)));
        Eigen::Vector2d pixel;
        if (!project(there.intrinsics, x_in_there, pixel)) continue;
        const double found = depth_at(to, pixel);
        if (found > 0) compare(found, x_in_there.z());
      }
  }

  DepthFlicker result() const {
    DepthFlicker out;
    const double n = static_cast<double>(points_), landed = n + static_cast<double>(jumps_);
    out.points = points_;
    out.mean = points_ > 0 ? size_ / n : nothing;
    out.bias = points_ > 0 ? signed_ / n : nothing;
    out.jump_share = landed > 0 ? static_cast<double>(jumps_) / landed : nothing;
    return out;
  }

 private:
  void compare(double found, double predicted) {
    const double change = (found - predicted) / predicted;
    if (std::fabs(change) > options_.jump) {
      ++jumps_;
      return;
    }
    ++points_;
    size_ += std::fabs(change);
    signed_ += change;
  }

  const FlickerOptions& options_;
  std::size_t points_ = 0, jumps_ = 0;
  double size_ = 0, signed_ = 0;
};

void require_one_size(const DepthMap& estimate, const DepthMap& truth, const ValidityMask* mask) {
  require(estimate.size() == truth.size(), "the estimate is {}x{}, the true depth {}x{} pixels", estimate.width(),
          estimate.height(), truth.width(), truth.height());
  require(mask == nullptr || mask->size() == truth.size(), "the mask does not have the size of the depth, {}x{} pixels",
          truth.width(), truth.height());
}

}  // namespace

DepthErrors compare_depth(const DepthMap& estimate, const DepthMap& truth, DepthFit fit, const ValidityMask* mask) {
  require_one_size(estimate, truth, mask);
  std::vector<Pair> pairs;
  std::size_t wanted = 0;
  for (std::size_t p = 0; p < truth.pixels().size(); ++p) {
    if (!is_valid_depth(truth.pixels()[p]) || (mask != nullptr && mask->pixels()[p] == 0)) continue;
    ++wanted;
    if (is_valid_depth(estimate.pixels()[p]))
      pairs.push_back({static_cast<double>(estimate.pixels()[p]), static_cast<double>(truth.pixels()[p])});
  }
  DepthErrors errors;
  forgive(pairs, fit, errors);
  errors.pixels = pairs.size();
  errors.valid_share = wanted > 0 ? static_cast<double>(pairs.size()) / static_cast<double>(wanted) : nothing;
  const double n = pairs.empty() ? nothing : static_cast<double>(pairs.size());
  double relative = 0, squared = 0, close = 0;
  for (const Pair& p : pairs) {
    const double difference = p.estimate - p.truth;
    relative += std::fabs(difference) / p.truth;
    squared += difference * difference;
    close += std::max(p.estimate / p.truth, p.truth / p.estimate) < 1.25 ? 1 : 0;
  }
  errors.abs_rel = relative / n;
  errors.rmse = std::sqrt(squared / n);
  errors.delta_125 = close / n;
  return errors;
}

void DepthEdgeOptions::check() const {
  require(std::isfinite(ratio) && ratio > 0, "edge ratio {} is not positive", ratio);
  require(tolerance >= 0 && tolerance <= 100, "edge tolerance {} is not in 0..100", tolerance);
}

DepthEdgeScore compare_depth_edges(const DepthMap& estimate, const DepthMap& truth, const DepthEdgeOptions& options,
                                   const ValidityMask* mask) {
  options.check();
  require_one_size(estimate, truth, mask);
  const ValidityMask judged = judged_pixels(truth, mask);
  const ValidityMask ours = edges_of(estimate, options.ratio, judged), theirs = edges_of(truth, options.ratio, judged);
  DepthEdgeScore score;
  score.precision = found_share(ours, theirs, options.tolerance, score.estimated);
  score.recall = found_share(theirs, ours, options.tolerance, score.true_edges);
  score.f = harmonic_mean(score);
  return score;
}

DepthEdgeScore pooled(std::span<const DepthEdgeScore> scores) {
  DepthEdgeScore all;
  double right = 0, found = 0;
  for (const DepthEdgeScore& score : scores) {
    if (score.estimated > 0) right += score.precision * static_cast<double>(score.estimated);
    if (score.true_edges > 0) found += score.recall * static_cast<double>(score.true_edges);
    all.estimated += score.estimated;
    all.true_edges += score.true_edges;
  }
  all.precision = all.estimated > 0 ? right / static_cast<double>(all.estimated) : nothing;
  all.recall = all.true_edges > 0 ? found / static_cast<double>(all.true_edges) : nothing;
  all.f = harmonic_mean(all);
  return all;
}

void FlickerOptions::check() const { require(std::isfinite(jump) && jump > 0, "jump {} is not positive", jump); }

DepthFlicker temporal_flicker(std::span<const DepthMap> depth, std::span<const Camera> cameras,
                              std::span<const ValidityMask> at_rest, const FlickerOptions& options) {
  options.check();
  require(depth.size() == cameras.size(), "{} depth maps want as many cameras, not {}", depth.size(), cameras.size());
  require(at_rest.empty() || at_rest.size() == depth.size(), "{} depth maps want as many masks, not {}", depth.size(),
          at_rest.size());
  for (std::size_t i = 0; i < depth.size(); ++i)
    require(cameras[i].size == depth[i].size() && (at_rest.empty() || at_rest[i].size() == depth[i].size()),
            "frame {}: depth, camera and mask differ in size", i);
  FlickerSum sum(options);
  for (std::size_t i = 0; i + 1 < depth.size(); ++i)
    sum.add(depth[i], cameras[i], depth[i + 1], cameras[i + 1], at_rest.empty() ? nullptr : &at_rest[i]);
  return sum.result();
}

}  // namespace uwv
