// SPDX-License-Identifier: Apache-2.0
#include "model/vae/winograd_kernel.h"

#include <algorithm>
#include <cstring>

#include "uwv/core/simd.h"

namespace uwv::model::winograd {
namespace {

constexpr std::int64_t side = tile + 2;

/// Sixteen channels: a line of the cache.
using Lanes = float __attribute__((vector_size(4 * channel_step)));

[[gnu::always_inline]] inline void load(const float* from, Lanes& x) { std::memcpy(&x, from, sizeof x); }
[[gnu::always_inline]] inline void store(float* to, const Lanes& x) { std::memcpy(to, &x, sizeof x); }

// Where the polynomials are looked at: 0, +-a, +-b and infinity. Rounding depends on them; of the pairs tried these
// give the least, less than half of what the usual 1 and 2 do. Their squares and products are exact.
constexpr float a = 0.625F, b = 1.5F;
constexpr float aa = a * a, bb = b * b;

/// Six pixels in a row, `step` apart, seen through polynomials that are 0 at all but one of those places.
[[gnu::always_inline]] inline void look(const Lanes* d, std::int64_t step, Lanes* to, std::int64_t to_step) {
  const Lanes d1 = d[step], d2 = d[2 * step], d3 = d[3 * step], d4 = d[4 * step];
  const Lanes even_a = d4 - bb * d2, odd_a = a * (d3 - bb * d1), even_b = d4 - aa * d2, odd_b = b * (d3 - aa * d1);
  to[0] = aa * bb * d[0] - (aa + bb) * d2 + d4;
  to[to_step] = even_a + odd_a;
  to[2 * to_step] = even_a - odd_a;
  to[3 * to_step] = even_b + odd_b;
  to[4 * to_step] = even_b - odd_b;
  to[5 * to_step] = aa * bb * d1 - (aa + bb) * d3 + d[5 * step];
}

/// The kernel's three numbers as a polynomial's values there, divided by what `look` leaves undivided.
[[gnu::always_inline]] inline void evaluate(const Lanes* g, std::int64_t step, Lanes* to, std::int64_t to_step) {
  constexpr float at_0 = 1 / (aa * bb), at_a = 1 / (2 * aa * (aa - bb)), at_b = 1 / (2 * bb * (bb - aa));
  const Lanes g0 = g[0], g1 = g[step], g2 = g[2 * step];
  const Lanes even_a = at_a * (g0 + aa * g2), odd_a = at_a * a * g1, even_b = at_b * (g0 + bb * g2);
  const Lanes odd_b = at_b * b * g1;
  to[0] = at_0 * g0;
  to[to_step] = even_a + odd_a;
  to[2 * to_step] = even_a - odd_a;
  to[3 * to_step] = even_b + odd_b;
  to[4 * to_step] = even_b - odd_b;
  to[5 * to_step] = g2;
}

/// Four results from six products.
[[gnu::always_inline]] inline void gather(const Lanes* m, std::int64_t step, Lanes* to, std::int64_t to_step) {
  const Lanes sum_a = m[step] + m[2 * step], difference_a = a * (m[step] - m[2 * step]);
  const Lanes sum_b = m[3 * step] + m[4 * step], difference_b = b * (m[3 * step] - m[4 * step]);
  to[0] = m[0] + sum_a + sum_b;
  to[to_step] = difference_a + difference_b;
  to[2 * to_step] = aa * sum_a + bb * sum_b;
  to[3 * to_step] = aa * difference_a + bb * difference_b + m[5 * step];
}

struct Place {
  std::int64_t y = 0, x = 0;
};

[[gnu::always_inline]] inline Place place_of(std::int64_t index, const TileRun& tiles) {
  return {index / tiles.columns() * tile, index % tiles.columns() * tile};
}

}  // namespace

UWV_SIMD_CLONES_512
void transform_frame(const float* frame, bool doubled, std::int64_t channels, const float* zeros, const TileRun& tiles,
                     const Planes& to) {
  const int shift = doubled ? 1 : 0;
  const std::int64_t row = (tiles.width >> shift) * channels;
  for (std::int64_t t = 0; t < tiles.count; ++t) {
    const Place at = place_of(tiles.first + t, tiles);
    const float* pixels[points];
    for (std::int64_t i = 0; i < points; ++i) {
      const std::int64_t y = at.y + i / side - 1 + tiles.above, x = at.x + i % side - 1;
      const bool inside = y >= 0 && y < tiles.seen && x >= 0 && x < tiles.width;
      pixels[i] = inside ? frame + (y >> shift) * row + (x >> shift) * channels : zeros;
    }
    float* const first = to.to + t * to.row;
    for (std::int64_t c = 0; c < channels; c += channel_step) {
      Lanes d[points], along[points];
      for (std::int64_t i = 0; i < points; ++i) load(pixels[i] + c, d[i]);
      for (std::int64_t i = 0; i < side; ++i) look(d + i * side, 1, along + i * side, 1);
      for (std::int64_t i = 0; i < side; ++i) look(along + i, side, d + i, side);
      for (std::int64_t i = 0; i < points; ++i) store(first + i * to.plane + c, d[i]);
    }
  }
}

UWV_SIMD_CLONES_512
void transform_weight(const float* weight, std::int64_t channels, std::int64_t outputs, std::int64_t begin,
                      std::int64_t end, const Planes& to) {
  for (std::int64_t c = begin; c < end; ++c)
    for (std::int64_t o = 0; o < outputs; o += channel_step) {
      Lanes g[9], along[18], u[points];
      for (std::int64_t i = 0; i < 9; ++i) load(weight + (i * channels + c) * outputs + o, g[i]);
      for (std::int64_t i = 0; i < 3; ++i) evaluate(g + i * 3, 1, along + i * side, 1);
      for (std::int64_t i = 0; i < side; ++i) evaluate(along + i, side, u + i, side);
      for (std::int64_t i = 0; i < points; ++i) store(to.to + i * to.plane + c * to.row + o, u[i]);
    }
}

UWV_SIMD_CLONES_512
void transform_sums(const float* sums, std::int64_t plane, std::int64_t channels, const float* bias, bool add,
                    const TileRun& tiles, float* frame) {
  for (std::int64_t t = 0; t < tiles.count; ++t) {
    const Place at = place_of(tiles.first + t, tiles);
    const std::int64_t rows = std::min(tile, tiles.height - at.y), columns = std::min(tile, tiles.width - at.x);
    for (std::int64_t c = 0; c < channels; c += channel_step) {
      Lanes m[points], along[tile * side], y[tile * tile], start{};
      for (std::int64_t i = 0; i < points; ++i) load(sums + i * plane + t * channels + c, m[i]);
      for (std::int64_t i = 0; i < side; ++i) gather(m + i, side, along + i, side);
      for (std::int64_t i = 0; i < tile; ++i) gather(along + i * side, 1, y + i * tile, 1);
      if (bias != nullptr) load(bias + c, start);
      for (std::int64_t i = 0; i < rows; ++i)
        for (std::int64_t j = 0; j < columns; ++j) {
          float* const to = frame + ((at.y + i) * tiles.width + at.x + j) * channels + c;
          Lanes sum = y[i * tile + j] + start, before{};
          if (add) load(to, before);
          sum += before;
          store(to, sum);
        }
    }
  }
}

}  // namespace uwv::model::winograd
