// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/decimation.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "uwv/core/depth.h"

namespace uwv {
namespace {

constexpr int smallest_cell = 4;

/// How a pixel of the source with some inverse depth lands in one target.
class Landing {
 public:
  Landing(const Camera& target, const Camera& source) {
    const Rigid3 motion = target_from_source(target, source);
    infinite_ = target.intrinsics.matrix() * motion.rotation * source.intrinsics.inverse_matrix();
    baseline_ = target.intrinsics.matrix() * motion.translation;
  }
  /// Whether inverse depths `a` and `b` at the pixel land within `limit` of each other (squared pixels).
  bool within(const Eigen::Vector3d& pixel, double a, double b, double limit2) const {
    const Eigen::Vector3d far = infinite_ * pixel;
    const Eigen::Vector3d p = far + a * baseline_, q = far + b * baseline_;
    if (!(p.z() > 0)) return true;
    if (!(q.z() > 0)) return false;
    return (p.hnormalized() - q.hnormalized()).squaredNorm() <= limit2;
  }

 private:
  Eigen::Matrix3d infinite_;
  Eigen::Vector3d baseline_;
};

/// Inverse depth around a pixel centre: value * (1 + x * dx + y * dy).
struct CellPlane {
  double value = 0, x = 0, y = 0;
};

class Quadtree {
 public:
  Quadtree(const DepthMap& depth, const Camera& source, std::span<const Camera> targets,
           const DecimationOptions& options, const ImageRgb* colours, DecimatedDepth& out)
      : depth_(depth), options_(options), colours_(colours), out_(out) {
    for (const Camera& target : targets) landings_.emplace_back(target, source);
  }

  /// Points for the cell of side `side` at (x0, y0).
  void divide(int x0, int y0, int side) {
    if (x0 >= depth_.width() || y0 >= depth_.height()) return;
    if (side == 1) {
      if (is_valid_depth(depth_(x0, y0))) put(x0, y0, 1, {1.0 / depth_(x0, y0), 0, 0}, depth_(x0, y0));
      return;
    }
    CellPlane plane;
    if (whole(x0, y0, side) && one_colour(x0, y0, side) && fit(x0, y0, side, plane)) {
      put(x0 + side / 2, y0 + side / 2, side, plane, static_cast<float>(1 / plane.value));
      return;
    }
    // Four pixels fit a plane nearly always, also across the edge between two surfaces; sixteen do not.
    const int part = side == smallest_cell ? 1 : side / 2;
    for (int y = y0; y < y0 + side; y += part)
      for (int x = x0; x < x0 + side; x += part) divide(x, y, part);
  }

 private:
  void put(int x, int y, int side, const CellPlane& plane, float z) {
    out_.kept(x, y) = 1;
    out_.cell(x, y) = static_cast<std::uint8_t>(side);
    out_.depth(x, y) = z;
    out_.slopes(x, y) = {static_cast<float>(plane.x), static_cast<float>(plane.y)};
  }

  /// Inside the picture, and every depth valid.
  bool whole(int x0, int y0, int side) const {
    if (x0 + side > depth_.width() || y0 + side > depth_.height()) return false;
    for (int y = y0; y < y0 + side; ++y)
      for (int x = x0; x < x0 + side; ++x)
        if (!is_valid_depth(depth_(x, y))) return false;
    return true;
  }

  bool one_colour(int x0, int y0, int side) const {
    if (colours_ == nullptr || options_.max_colour_difference >= 255) return true;
    Rgb8 low{255, 255, 255}, high{0, 0, 0};
    for (int y = y0; y < y0 + side; ++y)
      for (int x = x0; x < x0 + side; ++x) {
        const Rgb8& c = (*colours_)(x, y);
        low = {std::min(low.r, c.r), std::min(low.g, c.g), std::min(low.b, c.b)};
        high = {std::max(high.r, c.r), std::max(high.g, c.g), std::max(high.b, c.b)};
      }
    return std::max({high.r - low.r, high.g - low.g, high.b - low.b}) <= options_.max_colour_difference;
  }

  /// Least squares over the cell, rounded to what is stored, then checked pixel by pixel.
  bool fit(int x0, int y0, int side, CellPlane& plane) const {
    double sum = 0, sum_x = 0, sum_y = 0;
    const double middle = 0.5 * (side - 1);
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        const double w = 1.0 / depth_(x0 + x, y0 + y);
        sum += w;
        sum_x += w * (x - middle);
        sum_y += w * (y - middle);
      }
    const double count = static_cast<double>(side) * side;
    const double moment = count * (count - 1) / 12;  // sum of (x - middle)^2 over the cell
    const double from_middle = side / 2 - middle;    // of the pixel the point sits at
    const double value = sum / count + (sum_x + sum_y) / moment * from_middle;
    if (!(value > 0) || !std::isfinite(value)) return false;
    const float z = static_cast<float>(1 / value);
    if (!is_valid_depth(z)) return false;
    plane = {1.0 / z, static_cast<double>(static_cast<float>(sum_x / moment / value)),
             static_cast<double>(static_cast<float>(sum_y / moment / value))};
    return stays(x0, y0, side, plane);
  }

  bool stays(int x0, int y0, int side, const CellPlane& plane) const {
    const double limit2 = options_.max_error * options_.max_error;
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        const double w = plane.value * (1 + plane.x * (x - side / 2) + plane.y * (y - side / 2));
        if (!(w > 0)) return false;
        const Eigen::Vector3d pixel(x0 + x + 0.5, y0 + y + 0.5, 1);
        for (const Landing& landing : landings_)
          if (!landing.within(pixel, 1.0 / depth_(x0 + x, y0 + y), w, limit2)) return false;
      }
    return true;
  }

  const DepthMap& depth_;
  const DecimationOptions& options_;
  const ImageRgb* colours_;
  DecimatedDepth& out_;
  std::vector<Landing> landings_;
};

}  // namespace

void DecimationOptions::check() const {
  require(max_error >= 0 && max_error <= 1000, "max_error {} px is outside 0..1000", max_error);
  require(max_cell >= 1 && max_cell <= 64 && max_cell != 2 && std::has_single_bit(static_cast<unsigned>(max_cell)),
          "max_cell {} is none of 1, 4, 8, 16, 32, 64", max_cell);
  require(max_colour_difference >= 0 && max_colour_difference <= 255, "max_colour_difference {} is outside 0..255",
          max_colour_difference);
}

DecimatedDepth decimate_depth(const DepthMap& depth, const Camera& source, std::span<const Camera> targets,
                              const DecimationOptions& options, ThreadPool& pool, const ImageRgb* colours) {
  options.check();
  require(source.size == depth.size(), "decimate_depth: depth is {}x{}, its camera {}x{}", depth.width(),
          depth.height(), source.size.width, source.size.height);
  require(colours == nullptr || colours->size() == depth.size(), "decimate_depth: depth and colours differ in size");
  DecimatedDepth out;
  out.kept = ValidityMask(depth.size());
  out.cell = Image<std::uint8_t>(depth.size());
  out.depth = DepthMap(depth.size());
  out.slopes = SlopeMap(depth.size());
  const int side = options.max_cell;
  Quadtree tree(depth, source, targets, options, colours, out);
  pool.for_ranges(0, (depth.height() + side - 1) / side, 1, [&](int from, int to) {
    for (int row = from; row < to; ++row)
      for (int x = 0; x < depth.width(); x += side) tree.divide(x, row * side, side);
  });
  const auto valid = std::count_if(depth.pixels().begin(), depth.pixels().end(), is_valid_depth);
  out.kept_share = valid > 0 ? static_cast<double>(out.kept.count()) / static_cast<double>(valid) : 0.0;
  return out;
}

}  // namespace uwv
