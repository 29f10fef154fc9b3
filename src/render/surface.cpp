// SPDX-License-Identifier: Apache-2.0
#include "render/surface.h"

#include <cmath>

#include "render/footprint.h"
#include "uwv/core/simd.h"

namespace uwv::detail {
namespace {

/// The winners of a block of target pixels, gathered from the source so that the arithmetic can run in SIMD lanes.
struct Patches {
  alignas(64) std::array<float, block_size> x, y;       ///< Pixel centre in the source.
  alignas(64) std::array<float, block_size> z, sx, sy;  ///< Depth (0 = no winner) and slope there.
};

/// Where the pixels' rays meet the patches.
struct Surfels {
  alignas(64) std::array<float, block_size> depth;   ///< In the target; 0 = nothing.
  alignas(64) std::array<float, block_size> sx, sy;  ///< Slope in the target.
  alignas(64) std::array<float, block_size> x, y;    ///< Position in the source picture.
};

void gather_patches(const PointGrid& points, const std::uint32_t* winner, int count, Patches& out) {
  for (int i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const bool hit = winner[i] != PointCode::none;
    const int x = hit ? PointCode::x(winner[i]) : 0;
    const int y = hit ? PointCode::y(winner[i]) : 0;
    const Slope slope = points.slopes != nullptr ? (*points.slopes)(x, y) : Slope{};
    out.x[at] = static_cast<float>(x) + 0.5F;
    out.y[at] = static_cast<float>(y) + 0.5F;
    out.z[at] = hit ? (*points.depth)(x, y) : 0.0F;
    out.sx[at] = slope.x;
    out.sy[at] = slope.y;
  }
}

inline float clamped(float value, float limit) {
  const float low = value > -limit ? value : -limit;
  return low < limit ? low : limit;
}

UWV_SIMD_CLONES void meet_patches(const WarpMap& map, int x, int y, int count, const Patches& patches, Surfels& out) {
  const float r00 = map.a_inverse[0][0], r01 = map.a_inverse[0][1], r02 = map.a_inverse[0][2];
  const float r10 = map.a_inverse[1][0], r11 = map.a_inverse[1][1], r12 = map.a_inverse[1][2];
  const float r20 = map.a_inverse[2][0], r21 = map.a_inverse[2][1], r22 = map.a_inverse[2][2];
  const float k0 = map.k[0], k1 = map.k[1], k2 = map.k[2];
  // The forward map's third row without the folded half pixel.
  const float a20 = map.a[2][0], a21 = map.a[2][1], a22 = map.a[2][2] - 0.5F * (a20 + a21), b2 = map.b[2];
  const float cy = static_cast<float>(y) + 0.5F;
  const float* px = patches.x.data();
  const float* py = patches.y.data();
  const float* pz = patches.z.data();
  const float* psx = patches.sx.data();
  const float* psy = patches.sy.data();
  float* out_depth = out.depth.data();
  float* out_sx = out.sx.data();
  float* out_sy = out.sy.data();
  float* out_x = out.x.data();
  float* out_y = out.y.data();
#pragma GCC ivdep  // inputs and outputs never overlap
  for (int i = 0; i < count; ++i) {
    const float cx = static_cast<float>(x + i) + 0.5F;
    const float xs = px[i], ys = py[i];
    const float z = pz[i];
    const float m0 = psx[i], m1 = psy[i];
    const float m2 = 1.0F - m0 * xs - m1 * ys;
    const float n0 = r00 * m0 + r10 * m1 + r20 * m2;
    const float n1 = r01 * m0 + r11 * m1 + r21 * m2;
    const float n2 = r02 * m0 + r12 * m1 + r22 * m2;
    const float facing = 1.0F / (n0 * cx + n1 * cy + n2);
    const float z_plane = (z + (m0 * k0 + m1 * k1 + m2 * k2)) * facing;
    const float s0 = (r00 * cx + r01 * cy + r02) * z_plane - k0;
    const float s1 = (r10 * cx + r11 * cy + r12) * z_plane - k1;
    const float s2 = 1.0F / ((r20 * cx + r21 * cy + r22) * z_plane - k2);
    // Beyond its own patch a plane proves nothing: stay within reach of the winner.
    const float dx = clamped(s0 * s2 - xs, patch_reach);
    const float dy = clamped(s1 * s2 - ys, patch_reach);
    const float shrink = 1.0F + m0 * dx + m1 * dy;
    const float z_there = z / (shrink > 0.25F ? shrink : 1.0F);
    const float depth = z_there * (a20 * (xs + dx) + a21 * (ys + dy) + a22) + b2;
    const float own_depth = z * (a20 * xs + a21 * ys + a22) + b2;
    const bool hit = z > 0.0F;
    const bool sane = (depth > 0.5F * own_depth) & (depth < 2.0F * own_depth);
    const float limit = 64.0F;
    out_depth[i] = hit ? (sane ? depth : own_depth) : 0.0F;
    out_sx[i] = hit ? clamped(n0 * facing, limit) : 0.0F;
    out_sy[i] = hit ? clamped(n1 * facing, limit) : 0.0F;
    out_x[i] = xs + dx;
    out_y[i] = ys + dy;
  }
}

/// Calls emit(y, x, count, patches, surfels) for every block of the target.
template <class Emit>
void for_surfels(const PointGrid& points, const Camera& target, const ZBuffer& zbuffer, ThreadPool& pool,
                 const Emit& emit) {
  const WarpMap map = WarpMap::between(points.camera, target);
  pool.for_ranges(0, target.size.height, 8, [&](int from, int to) {
    Patches patches;
    Surfels surfels;
    for (int y = from; y < to; ++y)
      for (int x = 0; x < target.size.width; x += block_size) {
        const int count = std::min(block_size, target.size.width - x);
        gather_patches(points, zbuffer.winner.row(y) + x, count, patches);
        meet_patches(map, x, y, count, patches, surfels);
        emit(y, x, count, patches, surfels);
      }
  });
}

/// Neighbours whose depth leaves the winner's plane by more than this share belong to another surface.
constexpr float same_surface = 0.05F;

/// Bilinear colour at (x, y) of the source from the taps that lie on the patch's plane; the winner's own colour if none
/// does.
Rgb8 sample_on_patch(const PointGrid& points, const ImageRgb& source, float x, float y, const Patches& patches,
                     std::size_t at) {
  const float left = std::floor(x - 0.5F), top = std::floor(y - 0.5F);
  const float fx = x - 0.5F - left, fy = y - 0.5F - top;
  float r = 0, g = 0, b = 0, weights = 0;
  for (int tap = 0; tap < 4; ++tap) {
    const int tx = static_cast<int>(left) + (tap & 1), ty = static_cast<int>(top) + (tap >> 1);
    const float weight = ((tap & 1) != 0 ? fx : 1 - fx) * ((tap >> 1) != 0 ? fy : 1 - fy);
    if (!source.contains(tx, ty) || weight <= 0) continue;
    const float on_plane = 1.0F + patches.sx[at] * (static_cast<float>(tx) + 0.5F - patches.x[at]) +
                           patches.sy[at] * (static_cast<float>(ty) + 0.5F - patches.y[at]);
    const float z = (*points.depth)(tx, ty);
    if (!(std::fabs(z * on_plane - patches.z[at]) <= same_surface * patches.z[at])) continue;
    const Rgb8 c = source(tx, ty);
    r += weight * static_cast<float>(c.r);
    g += weight * static_cast<float>(c.g);
    b += weight * static_cast<float>(c.b);
    weights += weight;
  }
  if (!(weights > 1e-3F)) return source(static_cast<int>(patches.x[at]), static_cast<int>(patches.y[at]));
  const float scale = 1.0F / weights;
  const auto to_byte = [&](float sum) { return static_cast<std::uint8_t>(sum * scale + 0.5F); };
  return {to_byte(r), to_byte(g), to_byte(b)};
}

}  // namespace

void surface_geometry(const PointGrid& points, const Camera& target, const ZBuffer& zbuffer, ThreadPool& pool,
                      DepthMap& depth, SlopeMap* slopes) {
  depth.resize(target.size);
  if (slopes != nullptr) slopes->resize(target.size);
  for_surfels(points, target, zbuffer, pool, [&](int y, int x, int count, const Patches&, const Surfels& surfels) {
    std::copy_n(surfels.depth.begin(), count, depth.row(y) + x);
    if (slopes == nullptr) return;
    Slope* row = slopes->row(y) + x;
    for (int i = 0; i < count; ++i)
      row[i] = {surfels.sx[static_cast<std::size_t>(i)], surfels.sy[static_cast<std::size_t>(i)]};
  });
}

void nearest_colour(const ZBuffer& zbuffer, const ImageRgb& source, ThreadPool& pool, RenderedFrame& out) {
  const Size size = zbuffer.winner.size();
  out.colour.resize(size);
  out.valid.resize(size);
  pool.for_ranges(0, size.height, 16, [&](int from, int to) {
    for (int y = from; y < to; ++y) {
      const std::uint32_t* winner = zbuffer.winner.row(y);
      for (int x = 0; x < size.width; ++x) {
        const bool hit = winner[x] != PointCode::none;
        out.colour(x, y) = hit ? source(PointCode::x(winner[x]), PointCode::y(winner[x])) : Rgb8{};
        out.valid(x, y) = hit;
      }
    }
  });
}

void resampled_colour(const PointGrid& points, const Camera& target, const ZBuffer& zbuffer, const ImageRgb& source,
                      ThreadPool& pool, RenderedFrame& out) {
  out.colour.resize(target.size);
  out.valid.resize(target.size);
  out.depth.resize(target.size);
  for_surfels(points, target, zbuffer, pool,
              [&](int y, int x, int count, const Patches& patches, const Surfels& surfels) {
                std::copy_n(surfels.depth.begin(), count, out.depth.row(y) + x);
                for (int i = 0; i < count; ++i) {
                  const auto at = static_cast<std::size_t>(i);
                  const bool hit = patches.z[at] > 0;
                  out.valid(x + i, y) = hit;
                  out.colour(x + i, y) =
                      hit ? sample_on_patch(points, source, surfels.x[at], surfels.y[at], patches, at) : Rgb8{};
                }
              });
}

void visible_by_ztest(const PointGrid& points, const Camera& target, const DepthMap& depth, const SlopeMap& slopes,
                      float tolerance, ThreadPool& pool, ValidityMask& out) {
  const WarpMap map = WarpMap::between(points.camera, target);
  const Size size = points.camera.size;
  out.resize(size);
  pool.for_ranges(0, size.height, 8, [&](int from, int to) {
    for (int y = from; y < to; ++y)
      for (int x = 0; x < size.width; ++x) {
        const float z = (*points.depth)(x, y);
        const bool kept = points.keep == nullptr || (*points.keep)(x, y) != 0;
        out(x, y) = 0;
        if (!kept || !(z > 0)) continue;
        const WarpMap::Landing at = map.apply(x, y, z);
        if (!at.inside(target.size)) continue;
        const int tx = static_cast<int>(at.u), ty = static_cast<int>(at.v);
        const Slope& slope = slopes(tx, ty);
        const float centre = depth(tx, ty);
        const float bend =
            1.0F + slope.x * (at.u - static_cast<float>(tx) - 0.5F) + slope.y * (at.v - static_cast<float>(ty) - 0.5F);
        const float surface = bend > 0.25F ? centre / bend : centre;
        // An empty pixel hides nothing.
        out(x, y) = !(centre > 0) || at.depth <= surface * (1.0F + tolerance);
      }
  });
}

}  // namespace uwv::detail
