// SPDX-License-Identifier: Apache-2.0
// The colours of a z-buffer's pixels: the winner's own, or looked up where the pixel's ray meets the winner's patch.
#include <cmath>
#include <cstring>

#include "render/surface.h"
#include "render/surfels.h"
#include "uwv/core/simd.h"

namespace uwv::detail {
namespace {

/// Neighbours whose depth leaves the winner's plane by more than this share belong to another surface.
constexpr float same_surface = 0.05F;

using Lanes = std::array<float, block_size>;

/// The four source pixels around each position of a block. Those outside the picture stand for one inside, with
/// depth 0.
struct Taps {
  alignas(64) std::array<std::array<std::int32_t, block_size>, 4> index;
  alignas(64) std::array<Lanes, 4> depth;
  alignas(64) std::array<Lanes, 4> weight;                                  ///< Sum 1.
  alignas(64) std::array<std::array<std::uint32_t, block_size>, 4> colour;  ///< Red in the lowest byte.
};

/// A pixel as four bytes, the last of which is whatever follows it. `last` is the source's last pixel, which nothing
/// follows.
inline std::uint32_t load_pixel(const Rgb8* source, std::size_t at, std::size_t last) {
  std::uint32_t bytes = 0;
  std::memcpy(&bytes, source + at, at < last ? sizeof bytes : sizeof(Rgb8));
  return bytes;
}

/// Stores `count` pixels in a row, four bytes at a time where the next pixel overwrites the surplus one.
inline void store_pixels(const std::uint32_t* pixels, int count, Rgb8* out) {
  for (int i = 0; i + 1 < count; ++i) std::memcpy(static_cast<void*>(out + i), pixels + i, sizeof *pixels);
  std::memcpy(static_cast<void*>(out + count - 1), pixels + count - 1, sizeof(Rgb8));
}

/// Indices, and 1 or 0 in `depth` for inside or outside the picture.
UWV_SIMD_CLONES void place_taps(const Surfels& surfels, Size source, int count, int tap, Taps& out) {
  const float dx = static_cast<float>(tap & 1), dy = static_cast<float>(tap >> 1);
  const float last_x = static_cast<float>(source.width - 1), last_y = static_cast<float>(source.height - 1);
  const float* sx = surfels.x.data();
  const float* sy = surfels.y.data();
  std::int32_t* index = out.index[static_cast<std::size_t>(tap)].data();
  float* inside = out.depth[static_cast<std::size_t>(tap)].data();
#pragma GCC ivdep  // inputs and outputs never overlap
  for (int i = 0; i < count; ++i) {
    const float x = std::floor(sx[i] - 0.5F) + dx, y = std::floor(sy[i] - 0.5F) + dy;
    float cx = x > 0.0F ? x : 0.0F, cy = y > 0.0F ? y : 0.0F;
    cx = cx < last_x ? cx : last_x;
    cy = cy < last_y ? cy : last_y;
    index[i] = static_cast<std::int32_t>(cy) * source.width + static_cast<std::int32_t>(cx);
    inside[i] = (cx == x) & (cy == y) ? 1.0F : 0.0F;
  }
}

/// Bilinear weight of a tap, 0 unless it lies on the patch's plane.
UWV_SIMD_CLONES void weigh_taps(const Patches& patches, const Surfels& surfels, int count, int tap, Taps& taps) {
  const float right = static_cast<float>(tap & 1), bottom = static_cast<float>(tap >> 1);
  const float* sx = surfels.x.data();
  const float* sy = surfels.y.data();
  const float* px = patches.x.data();
  const float* py = patches.y.data();
  const float* pz = patches.z.data();
  const float* slope_x = patches.sx.data();
  const float* slope_y = patches.sy.data();
  const float* depth = taps.depth[static_cast<std::size_t>(tap)].data();
  float* weight = taps.weight[static_cast<std::size_t>(tap)].data();
#pragma GCC ivdep  // inputs and outputs never overlap
  for (int i = 0; i < count; ++i) {
    const float left = std::floor(sx[i] - 0.5F), top = std::floor(sy[i] - 0.5F);
    const float fx = sx[i] - 0.5F - left, fy = sy[i] - 0.5F - top;
    const float wx = right > 0.0F ? fx : 1.0F - fx, wy = bottom > 0.0F ? fy : 1.0F - fy;
    const float on_plane =
        1.0F + slope_x[i] * (left + right + 0.5F - px[i]) + slope_y[i] * (top + bottom + 0.5F - py[i]);
    const float z = depth[i];
    const bool same = (z > 0.0F) & (std::fabs(z * on_plane - pz[i]) <= same_surface * pz[i]);
    weight[i] = same ? wx * wy : 0.0F;
  }
}

/// Weights to sum 1; where no tap is left, the first stands for the winner itself.
UWV_SIMD_CLONES void normalise_taps(const Patches& patches, int count, Taps& taps) {
  float* w0 = taps.weight[0].data();
  float* w1 = taps.weight[1].data();
  float* w2 = taps.weight[2].data();
  float* w3 = taps.weight[3].data();
  std::int32_t* index = taps.index[0].data();
  const std::int32_t* winner = patches.index.data();
#pragma GCC ivdep  // these never overlap
  for (int i = 0; i < count; ++i) {
    const float sum = (w0[i] + w1[i]) + (w2[i] + w3[i]);
    const bool enough = sum > 1e-3F;
    const float scale = enough ? 1.0F / sum : 0.0F;
    w0[i] = enough ? w0[i] * scale : 1.0F;
    w1[i] *= scale;
    w2[i] *= scale;
    w3[i] *= scale;
    index[i] = enough ? index[i] : winner[i];
  }
}

void find_taps(const PointGrid& points, const Patches& patches, const Surfels& surfels, int count, Taps& taps) {
  const float* depth = points.depth->data();
  for (int tap = 0; tap < 4; ++tap) {
    place_taps(surfels, points.camera.size, count, tap, taps);
    const auto t = static_cast<std::size_t>(tap);
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) taps.depth[t][i] *= depth[taps.index[t][i]];
    weigh_taps(patches, surfels, count, tap, taps);
  }
  normalise_taps(patches, count, taps);
}

void fetch_colours(const ImageRgb& source, int count, Taps& taps) {
  const std::size_t last = source.size().pixels() - 1;
  for (std::size_t tap = 0; tap < 4; ++tap)
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
      taps.colour[tap][i] = load_pixel(source.data(), static_cast<std::size_t>(taps.index[tap][i]), last);
}

/// Weighted colours, 0 where there is no winner.
UWV_SIMD_CLONES void blend_taps(const Patches& patches, const Taps& taps, int count, std::uint32_t* out) {
  const float* z = patches.z.data();
  const float *w0 = taps.weight[0].data(), *w1 = taps.weight[1].data(), *w2 = taps.weight[2].data(),
              *w3 = taps.weight[3].data();
  const std::uint32_t *c0 = taps.colour[0].data(), *c1 = taps.colour[1].data(), *c2 = taps.colour[2].data(),
                      *c3 = taps.colour[3].data();
#pragma GCC ivdep  // inputs and outputs never overlap
  for (int i = 0; i < count; ++i) {
    std::uint32_t pixel = 0;
    for (int shift = 0; shift < 24; shift += 8) {
      const auto channel = [shift](std::uint32_t c) {
        return static_cast<float>(static_cast<std::int32_t>(c >> shift & 0xFFU));
      };
      const float sum = 0.5F + w0[i] * channel(c0[i]) + w1[i] * channel(c1[i]) + w2[i] * channel(c2[i]) +
                        w3[i] * channel(c3[i]);  // 0.5: to the nearest
      pixel |= static_cast<std::uint32_t>(static_cast<std::int32_t>(sum)) << shift;
    }
    out[i] = z[i] > 0.0F ? pixel : 0;
  }
}

/// Colours of a row's winners.
void copy_colours(const std::uint32_t* winner, const ImageRgb& source, int width, Rgb8* out) {
  const auto source_width = static_cast<std::size_t>(source.width());
  const std::size_t last = source.size().pixels() - 1;
  std::array<std::uint32_t, block_size> pixels;
  for (int x = 0; x < width; x += block_size) {
    const int count = std::min(block_size, width - x);
    for (int i = 0; i < count; ++i) {
      const std::uint32_t code = winner[x + i];
      const bool hit = code != PointCode::none;
      const std::size_t at = hit ? (code >> 16) * source_width + (code & 0xFFFFU) : 0;
      const std::uint32_t pixel = load_pixel(source.data(), at, last);
      pixels[static_cast<std::size_t>(i)] = hit ? pixel : 0;
    }
    store_pixels(pixels.data(), count, out + x);
  }
}

}  // namespace

void nearest_colour(const ZBuffer& zbuffer, const ImageRgb& source, ThreadPool& pool, RenderedFrame& out) {
  const Size size = zbuffer.winner.size();
  out.colour.resize(size);
  out.valid.resize(size);
  out.depth.resize(size);
  pool.for_ranges(0, size.height, 16, [&](int from, int to) {
    for (int y = from; y < to; ++y) {
      const std::uint32_t* winner = zbuffer.winner.row(y);
      Rgb8* colour = out.colour.row(y);
      std::uint8_t* valid = out.valid.row(y);
      std::copy_n(zbuffer.depth.row(y), size.width, out.depth.row(y));
      for (int x = 0; x < size.width; ++x) valid[x] = static_cast<std::uint8_t>(winner[x] != PointCode::none);
      copy_colours(winner, source, size.width, colour);
    }
  });
}

void resampled_colour(const PointGrid& points, const Camera& target, const ZBuffer& zbuffer, const ImageRgb& source,
                      ThreadPool& pool, RenderedFrame& out) {
  out.colour.resize(target.size);
  out.valid.resize(target.size);
  out.depth.resize(target.size);
  const auto empty = [&](int y, int x, int count) {
    std::fill_n(out.colour.row(y) + x, count, Rgb8{});
    std::fill_n(out.depth.row(y) + x, count, 0.0F);
    std::fill_n(out.valid.row(y) + x, count, std::uint8_t{0});
  };
  const auto emit = [&](int y, int x, int count, const Patches& patches, const Surfels& surfels) {
    Taps taps;
    find_taps(points, patches, surfels, count, taps);
    std::copy_n(surfels.depth.begin(), count, out.depth.row(y) + x);
    fetch_colours(source, count, taps);
    std::array<std::uint32_t, block_size> pixels;
    blend_taps(patches, taps, count, pixels.data());
    store_pixels(pixels.data(), count, out.colour.row(y) + x);
    std::transform(patches.z.begin(), patches.z.begin() + count, out.valid.row(y) + x,
                   [](float z) { return static_cast<std::uint8_t>(z > 0); });
  };
  for_surfels(points, target, zbuffer, pool, emit, empty);
}

}  // namespace uwv::detail
