// SPDX-License-Identifier: Apache-2.0
#include "geometry/mvs/carry.h"

#include <algorithm>
#include <cmath>

#include "geometry/mvs/reprojection.h"

namespace uwv::mvs {
namespace {

void splat(const KeyDepth& key, const View& target, float tolerance, RatedDepth& out) {
  const Reprojection to_target = make_reprojection(key.view->camera, target.camera);
  const InverseDepthMap& from = key.depth->inverse_depth;
  for (int y = 0; y < from.height(); ++y) {
    for (int x = 0; x < from.width(); ++x) {
      const float w = from(x, y);
      if (w <= 0) continue;
      const Eigen::Vector3f p =
          to_target.pixel_from_pixel * Eigen::Vector3f(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F, 1) +
          w * to_target.shift;
      if (!(p.z() > 1e-6F)) continue;
      const float u = p.x() / p.z();
      const float v = p.y() / p.z();
      const bool inside =
          u >= 0 && v >= 0 && u < static_cast<float>(from.width()) && v < static_cast<float>(from.height());
      if (!inside) continue;
      const int iu = static_cast<int>(u);
      const int iv = static_cast<int>(v);
      const float landed = w / p.z();
      const float present = out.inverse_depth(iu, iv);
      const float confidence = key.depth->confidence(x, y);
      // On the same surface the better measurement wins, on different ones the nearer.
      const bool same = std::abs(landed - present) <= tolerance * present;
      if (same ? confidence <= out.confidence(iu, iv) : landed <= present) continue;
      out.inverse_depth(iu, iv) = landed;
      out.confidence(iu, iv) = confidence;
    }
  }
}

/// Closes gaps one pixel wide that a surface gets when it grows, and through which what is behind it may show.
RatedDepth close_cracks(const RatedDepth& in, float tolerance) {
  RatedDepth out = in;
  const InverseDepthMap& w = in.inverse_depth;
  const auto bridge = [&](int x, int y, int dx, int dy) {
    if (!w.contains(x - dx, y - dy) || !w.contains(x + dx, y + dy)) return;
    const float a = w(x - dx, y - dy);
    const float b = w(x + dx, y + dy);
    if (a <= 0 || b <= 0 || std::abs(a - b) > tolerance * std::min(a, b)) return;
    const float mean = 0.5F * (a + b);
    if (w(x, y) >= mean * (1 - 2 * tolerance)) return;
    out.inverse_depth(x, y) = mean;
    out.confidence(x, y) = std::min(in.confidence(x - dx, y - dy), in.confidence(x + dx, y + dy));
  };
  for (int y = 0; y < w.height(); ++y) {
    for (int x = 0; x < w.width(); ++x) {
      bridge(x, y, 1, 0);
      bridge(x, y, 0, 1);
    }
  }
  return out;
}

}  // namespace

RatedDepth carry(const View& target, const std::vector<KeyDepth>& keys, double tolerance) {
  const Size size = target.grey.size();
  RatedDepth moved{InverseDepthMap(size), Image<float>(size)};
  std::vector<Reprojection> to_keys;
  for (const KeyDepth& key : keys) {
    splat(key, target, static_cast<float>(tolerance), moved);
    to_keys.push_back(make_reprojection(target.camera, key.view->camera));
  }
  moved = close_cracks(moved, static_cast<float>(tolerance));
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const float w = moved.inverse_depth(x, y);
      const bool usable = target.usable.empty() || target.usable(x, y) != 0;
      float sum = 0;
      int agree = 0;
      for (std::size_t k = 0; usable && w > 0 && k < keys.size(); ++k) {
        const float agreed =
            agreed_inverse_depth(to_keys[k], keys[k].depth->inverse_depth, static_cast<float>(x) + 0.5F,
                                 static_cast<float>(y) + 0.5F, w, static_cast<float>(tolerance));
        if (agreed <= 0) continue;
        sum += agreed;
        ++agree;
      }
      moved.inverse_depth(x, y) = agree > 0 ? sum / static_cast<float>(agree) : 0.0F;
      if (agree == 0) moved.confidence(x, y) = 0;
    }
  }
  return moved;
}

}  // namespace uwv::mvs
