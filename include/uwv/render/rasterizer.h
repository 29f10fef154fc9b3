// SPDX-License-Identifier: Apache-2.0
// Moving a point grid into another camera: the three primitives every pass of Algorithm 1 is made of. Two
// implementations (CPU and OpenGL) give the same answer; see docs/rendering.md for the arithmetic both follow to the
// letter.
//
// Footprint. A source pixel is a small patch of surface, not a dot. Its image in the target is, to first order, the
// parallelogram spanned by the columns of the warp's Jacobian J at that pixel, which follows from depth and slope
// alone:
//     J00 = ((z*a00 + b0*sx) - u*(z*a20 + b2*sx)) * r     J01 = ((z*a01 + b0*sy) - u*(z*a21 + b2*sy)) * r
//     J10 = ((z*a10 + b1*sx) - v*(z*a20 + b2*sx)) * r     J11 = ((z*a11 + b1*sy) - v*(z*a21 + b2*sy)) * r      r = 1/p2
// We draw the parallelogram's bounding rectangle: half sides hx = point_size*(|J00|+|J01|)/2 and hy likewise, clamped
// to [min_footprint/2, max_footprint/2]. Covered are the pixels x0..x1, y0..y1 with
//     x0 = max(0, ceil(u - (hx + 0.5)))     x1 = min(width - 1, ceil(u + (hx - 0.5)) - 1)     (y likewise):
// those whose centres lie in [u - hx, u + hx). A surface that comes closer or turns towards the camera therefore stays
// closed. Points with p2 <= 0, p2 > max_depth or a NaN anywhere draw nothing. The nearest p2 wins a pixel; ties go to
// the lower code.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "uwv/core/image.h"
#include "uwv/render/point_grid.h"

namespace uwv {

/// 32-bit float colour, red first. The range is the caller's ([0, 1] or the reference's [-1, 1]).
struct RgbF {
  float r = 0, g = 0, b = 0;
};
using ImageRgbF = Image<RgbF>;

struct FootprintOptions {
  /// Scales every footprint. 1 = exactly the patch; more closes cracks of noisy depth at the price of fatter edges.
  float point_size = 1.0F;
  /// Smallest side of a footprint in pixels, at least 1: any less and a surface that moves away would fall apart.
  float min_footprint = 1.0F;
  /// Largest side of a footprint in pixels. Surfaces almost edge-on in the source would otherwise smear; 255 is GL's
  /// limit.
  float max_footprint = 16.0F;
  void check() const;
};

/// A rectangle of pixels, inclusive; empty when x1 < x0.
struct PixelBox {
  std::int32_t x0 = 0, x1 = -1, y0 = 0, y1 = -1;
  bool empty() const { return x1 < x0; }
};

/// Which point each target pixel shows.
struct ZBuffer {
  Image<std::uint32_t> winner;  ///< PointCode of the nearest point, or PointCode::none.
  DepthMap depth;               ///< That point's own depth in the target; 0 where there is none.
  std::vector<PixelBox> reach;  ///< The renderer's note to itself for narrow(): what its blocks of points cover.
};

/// The reference's soft z-test (geometry sheet 5.1): every point adds to its four neighbours with bilinear weight
/// divided by exp(sharpness * L / L_max), L = ln(1 + clamp(z, 0, 1000)).
struct SoftSplatOptions {
  float sharpness = 50.0F;
  /// L_max. The reference takes the maximum over its whole batch of frames, so one frame's picture depends on the
  /// others; 0 takes it over this grid (masked points and points behind the camera included, as there).
  float log_depth_max = 0.0F;
};

/// What a soft splat gives. colour and depth are weighted means (0 where nothing landed).
struct SoftSplat {
  ImageRgbF colour;
  DepthMap depth;
  ValidityMask valid;
};

/// One renderer with its scratch memory. Not thread-safe: one object per thread of the caller.
class Rasterizer {
 public:
  virtual ~Rasterizer() = default;

  /// "cpu", or "gl" with the driver's name.
  virtual std::string name() const = 0;

  /// Nearest point per pixel of `target` (target.size must be positive, sides at most 65535). `out` is resized as
  /// needed.
  virtual void zbuffer(const PointGrid& points, const Camera& target, const FootprintOptions& options,
                       ZBuffer& out) = 0;

  /// Narrows `zbuffer`, which holds what a superset of `points` gave for the same target and options, to `points`.
  /// Removing a point changes only the pixels it won: returns how many those are, 0 = nothing to do. Gives what
  /// zbuffer() would, for the price of the pixels that change where the renderer can (the CPU's).
  virtual std::size_t narrow(const PointGrid& points, const Camera& target, const FootprintOptions& options,
                             ZBuffer& zbuffer);

  /// Draws points into the pixels that `zbuffer` leaves empty, and nowhere else.
  virtual void fill(const PointGrid& points, const Camera& target, const FootprintOptions& options, ZBuffer& zbuffer);

  /// 1 where any point's footprint lands; what M'' needs, cheaper than a z-buffer.
  virtual void coverage(const PointGrid& points, const Camera& target, const FootprintOptions& options,
                        ValidityMask& out) = 0;

  /// The way back of Algorithm 1 in one step: coverage, in the points' own camera, of the surface that `zbuffer` (their
  /// rendering) shows in `target`. False = this renderer has no such step, and `out` is untouched: make the surface
  /// with its depth and slopes and call coverage(), which gives the same.
  virtual bool come_back(const PointGrid& points, const Camera& target, const ZBuffer& zbuffer,
                         const FootprintOptions& options, ValidityMask& out);

  /// The official bilinear soft-z splat. `colour` has the grid's size. Footprints do not apply: each point touches the
  /// (up to) four pixels around it. Null `colour` splats depth only and leaves out.colour empty.
  virtual void soft_splat(const PointGrid& points, const ImageRgbF* colour, const Camera& target,
                          const SoftSplatOptions& options, SoftSplat& out) = 0;
};

/// The SIMD and multi-threaded CPU renderer; `pool` outlives it.
std::unique_ptr<Rasterizer> make_cpu_rasterizer(ThreadPool& pool);

}  // namespace uwv
