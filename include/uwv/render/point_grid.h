// SPDX-License-Identifier: Apache-2.0
// A picture with depth, seen as a point cloud: point (x, y) is the pixel's centre pushed out to its depth. This is the
// paper's inverse projection (Eq. "pcd"), without ever storing world coordinates: a camera far from the world's origin
// loses no precision, and a renderer needs 4 bytes a point plus the picture.
#pragma once

#include <array>

#include "uwv/core/camera.h"
#include "uwv/core/depth.h"
#include "uwv/core/mask.h"
#include "uwv/geometry/slopes.h"

namespace uwv {

/// Non-owning view of one lifted picture; everything pointed to has camera.size and outlives the call it is passed to.
/// Sides are at most 65535 pixels.
struct PointGrid {
  Camera camera;                       ///< Where the picture was taken.
  const DepthMap* depth = nullptr;     ///< Required; 0 = no point.
  const SlopeMap* slopes = nullptr;    ///< Null = every point faces the camera.
  const ValidityMask* keep = nullptr;  ///< Null = all; 0 drops the point.
  /// Null = a point stands for its own pixel. Else, at points that are kept, the side s >= 1 of the square of pixels
  /// from (x - x % s, y - y % s) on that the point stands for with its plane (see decimation.h). CPU renderer only.
  const Image<std::uint8_t>* cells = nullptr;
  /// Throws std::invalid_argument unless the sizes agree and the camera can be inverted.
  void check() const;
};

/// Names a grid's point in 32 bits. Comparing codes orders points row by row.
struct PointCode {
  static constexpr std::uint32_t none = 0xFFFFFFFFU;
  static std::uint32_t pack(int x, int y) {
    return static_cast<std::uint32_t>(y) << 16 | static_cast<std::uint32_t>(x);
  }
  static int x(std::uint32_t code) { return static_cast<int>(code & 0xFFFFU); }
  static int y(std::uint32_t code) { return static_cast<int>(code >> 16); }
};

/// The map from a grid's pixels into another camera. With X = (x + 0.5, y + 0.5, 1) and depth z at that pixel,
///     p = z * A * X + b,     u = p0 / p2,  v = p1 / p2,  depth in the target = p2,
/// where A = K_t R K_s^-1 and b = K_t t are formed in double and rounded once. The half-pixel shift is folded into
/// A's last column (`a[i][2]`), so hot loops use the integer x and y. CPU and GLSL evaluate, for i = 0, 1, 2 and in
/// this order without contraction,   ray_i = a[i][0]*x + (a[i][1]*y + a[i][2]);   p_i = z*ray_i + b[i].
struct WarpMap {
  std::array<std::array<float, 3>, 3> a{};
  std::array<float, 3> b{};
  /// The way back, for target pixel centres c = (x + 0.5, y + 0.5, 1): s = a_inverse * c * z_t - k;  x_s = s0/s2, y_s =
  /// s1/s2, with the source's pixel centres at +0.5 (not folded) and k = A^-1 b.
  std::array<std::array<float, 3>, 3> a_inverse{};
  std::array<float, 3> k{};
  bool no_translation = false;  ///< b is exactly zero: no parallax, whatever the depth.
  bool identity = false;        ///< Source and target are the same camera: every pixel maps to itself.

  static WarpMap between(const Camera& source, const Camera& target);

  /// Where a point lands. u and v mean nothing unless depth > 0.
  struct Landing {
    float u = 0, v = 0, depth = 0;
    bool inside(Size target) const {
      return depth > 0 && u >= 0 && v >= 0 && u < static_cast<float>(target.width) &&
             v < static_cast<float>(target.height);
    }
  };
  /// The map applied to pixel (x, y) with depth z, for loops that are not worth writing in SIMD lanes.
  Landing apply(int x, int y, float z) const {
    const auto row = [&](std::size_t i) {
      return z * (a[i][0] * static_cast<float>(x) + (a[i][1] * static_cast<float>(y) + a[i][2])) + b[i];
    };
    const float depth = row(2);
    return {row(0) / depth, row(1) / depth, depth};
  }
};

}  // namespace uwv
