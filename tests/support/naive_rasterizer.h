// SPDX-License-Identifier: Apache-2.0
// The rasteriser as its headers define it (point_grid.h, rasterizer.h), one plain float loop per primitive and nothing
// clever: what the CPU and OpenGL renderers are compared with. Slow on purpose.
#pragma once

#include <algorithm>
#include <cmath>

#include "uwv/core/depth.h"
#include "uwv/render/rasterizer.h"

namespace uwv::testing {

/// Where one point of a grid lands in the target. `drawn` is false when it draws nothing.
struct NaivePoint {
  bool drawn = false;
  float u = 0, v = 0, z = 0;             ///< Pixel position and depth in the target.
  int x0 = 0, y0 = 0, x1 = -1, y1 = -1;  ///< Inclusive footprint; empty when x1 < x0 or y1 < y0.
};

/// Position and depth only; `drawn` when the point is valid, kept, and in front of the target.
inline NaivePoint naive_project(const PointGrid& points, const WarpMap& map, int x, int y) {
  NaivePoint point;
  const float z = (*points.depth)(x, y);
  if (!(z > 0) || (points.keep != nullptr && (*points.keep)(x, y) == 0)) return point;
  float p[3];
  for (std::size_t i = 0; i < 3; ++i) {
    const float ray = map.a[i][0] * static_cast<float>(x) + (map.a[i][1] * static_cast<float>(y) + map.a[i][2]);
    p[i] = z * ray + map.b[i];
  }
  point.u = p[0] / p[2];
  point.v = p[1] / p[2];
  point.z = p[2];
  point.drawn = p[2] > 0 && p[2] <= max_depth && !std::isnan(point.u) && !std::isnan(point.v);
  return point;
}

/// The point with its footprint, clipped to `size`.
inline NaivePoint naive_footprint(const PointGrid& points, const WarpMap& map, const FootprintOptions& options,
                                  Size size, int x, int y) {
  NaivePoint point = naive_project(points, map, x, y);
  if (!point.drawn) return point;
  const float z = (*points.depth)(x, y);
  const Slope slope = points.slopes == nullptr ? Slope{} : (*points.slopes)(x, y);
  const auto& a = map.a;
  const auto& b = map.b;
  const float inverse = 1 / point.z;
  const float wx = z * a[2][0] + b[2] * slope.x;
  const float wy = z * a[2][1] + b[2] * slope.y;
  const float j00 = ((z * a[0][0] + b[0] * slope.x) - point.u * wx) * inverse;
  const float j01 = ((z * a[0][1] + b[0] * slope.y) - point.u * wy) * inverse;
  const float j10 = ((z * a[1][0] + b[1] * slope.x) - point.v * wx) * inverse;
  const float j11 = ((z * a[1][1] + b[1] * slope.y) - point.v * wy) * inverse;
  float hx = options.point_size * (std::abs(j00) + std::abs(j01)) / 2;
  float hy = options.point_size * (std::abs(j10) + std::abs(j11)) / 2;
  if (std::isnan(hx) || std::isnan(hy)) {
    point.drawn = false;
    return point;
  }
  hx = std::clamp(hx, options.min_footprint / 2, options.max_footprint / 2);
  hy = std::clamp(hy, options.min_footprint / 2, options.max_footprint / 2);
  // Compared as floats: positions may be far outside what an int holds.
  const float x0 = std::max(0.0F, std::ceil(point.u - (hx + 0.5F)));
  const float y0 = std::max(0.0F, std::ceil(point.v - (hy + 0.5F)));
  const float x1 = std::min(static_cast<float>(size.width - 1), std::ceil(point.u + (hx - 0.5F)) - 1);
  const float y1 = std::min(static_cast<float>(size.height - 1), std::ceil(point.v + (hy - 0.5F)) - 1);
  if (x0 > x1 || y0 > y1) return point;
  point.x0 = static_cast<int>(x0);
  point.y0 = static_cast<int>(y0);
  point.x1 = static_cast<int>(x1);
  point.y1 = static_cast<int>(y1);
  return point;
}

inline void naive_zbuffer(const PointGrid& points, const Camera& target, const FootprintOptions& options,
                          ZBuffer& out) {
  const WarpMap map = WarpMap::between(points.camera, target);
  out.winner = Image<std::uint32_t>(target.size, PointCode::none);
  out.depth = DepthMap(target.size, 0.0F);
  for (int y = 0; y < points.camera.size.height; ++y)
    for (int x = 0; x < points.camera.size.width; ++x) {
      const NaivePoint point = naive_footprint(points, map, options, target.size, x, y);
      if (!point.drawn) continue;
      for (int ty = point.y0; ty <= point.y1; ++ty)
        for (int tx = point.x0; tx <= point.x1; ++tx) {
          // Points come in the order of their codes, so a strict comparison leaves ties to the lower code.
          if (out.winner(tx, ty) != PointCode::none && !(point.z < out.depth(tx, ty))) continue;
          out.winner(tx, ty) = PointCode::pack(x, y);
          out.depth(tx, ty) = point.z;
        }
    }
}

inline void naive_coverage(const PointGrid& points, const Camera& target, const FootprintOptions& options,
                           ValidityMask& out) {
  ZBuffer nearest;
  naive_zbuffer(points, target, options, nearest);
  out = ValidityMask(target.size, 0);
  for (std::size_t i = 0; i < target.size.pixels(); ++i)
    out.data()[i] = nearest.winner.data()[i] != PointCode::none ? 1 : 0;
}

/// L of the soft z-test.
inline float naive_log_depth(float z) { return std::log(1.0F + std::clamp(z, 0.0F, 1000.0F)); }

/// L_max over every point that has a depth, whether kept or not and wherever it lands.
inline float naive_log_depth_max(const PointGrid& points, const WarpMap& map) {
  float largest = 0;
  for (int y = 0; y < points.camera.size.height; ++y)
    for (int x = 0; x < points.camera.size.width; ++x) {
      const float z = (*points.depth)(x, y);
      if (!(z > 0)) continue;
      const float ray = map.a[2][0] * static_cast<float>(x) + (map.a[2][1] * static_cast<float>(y) + map.a[2][2]);
      const float z_target = z * ray + map.b[2];
      if (!std::isnan(z_target)) largest = std::max(largest, naive_log_depth(z_target));
    }
  return largest;
}

inline void naive_soft_splat(const PointGrid& points, const ImageRgbF* colour, const Camera& target,
                             const SoftSplatOptions& options, SoftSplat& out) {
  const WarpMap map = WarpMap::between(points.camera, target);
  const float log_max = options.log_depth_max > 0 ? options.log_depth_max : naive_log_depth_max(points, map);
  const int width = target.size.width, height = target.size.height;
  out.colour = ImageRgbF(colour == nullptr ? Size{} : target.size, RgbF{});
  out.depth = DepthMap(target.size, 0.0F);
  out.valid = ValidityMask(target.size, 0);
  Image<float> weights(target.size, 0.0F);
  const auto add = [&](float fx, float fy, float weight, float z, const RgbF& rgb) {
    // Pixel 0 of the reference's canvas is its padding.
    if (!(fx >= 1 && fy >= 1 && fx <= static_cast<float>(width) && fy <= static_cast<float>(height))) return;
    const int tx = static_cast<int>(fx) - 1, ty = static_cast<int>(fy) - 1;
    weights(tx, ty) += weight;
    out.depth(tx, ty) += z * weight;
    if (colour == nullptr) return;
    RgbF& sum = out.colour(tx, ty);
    sum = {sum.r + rgb.r * weight, sum.g + rgb.g * weight, sum.b + rgb.b * weight};
  };
  for (int y = 0; y < points.camera.size.height; ++y)
    for (int x = 0; x < points.camera.size.width; ++x) {
      const NaivePoint point = naive_project(points, map, x, y);
      if (!point.drawn) continue;
      const float share = log_max > 0 ? naive_log_depth(point.z) / log_max : 0.0F;
      const float weight = 1.0F / std::exp(options.sharpness * share);
      // u - 0.5 has the reference's integer centres; + 1 is its padding.
      const float px = std::clamp(point.u + 0.5F, 0.0F, static_cast<float>(width + 1));
      const float py = std::clamp(point.v + 0.5F, 0.0F, static_cast<float>(height + 1));
      const float x0 = std::floor(px), x1 = std::ceil(px), y0 = std::floor(py), y1 = std::ceil(py);
      const RgbF rgb = colour == nullptr ? RgbF{} : (*colour)(x, y);
      add(x0, y0, (1 - (py - y0)) * (1 - (px - x0)) * weight, point.z, rgb);
      add(x0, y1, (1 - (y1 - py)) * (1 - (px - x0)) * weight, point.z, rgb);
      add(x1, y0, (1 - (py - y0)) * (1 - (x1 - px)) * weight, point.z, rgb);
      add(x1, y1, (1 - (y1 - py)) * (1 - (x1 - px)) * weight, point.z, rgb);
    }
  for (std::size_t i = 0; i < target.size.pixels(); ++i) {
    const float weight = weights.data()[i];
    if (!(weight > 0)) {
      out.depth.data()[i] = 0;
      if (colour != nullptr) out.colour.data()[i] = {};
      continue;
    }
    out.valid.data()[i] = 1;
    out.depth.data()[i] /= weight;
    if (colour == nullptr) continue;
    RgbF& sum = out.colour.data()[i];
    sum = {sum.r / weight, sum.g / weight, sum.b / weight};
  }
}

}  // namespace uwv::testing
