// SPDX-License-Identifier: Apache-2.0
// The three transforms of Winograd's convolution F(4x4, 3x3) (Lavin and Gray, 2016): sixteen results of a 3x3 kernel
// from 36 products instead of 144. Torch-free; numbers lie channel by channel within a pixel, 16 channels at a time.
#pragma once

#include <cstdint>

namespace uwv::model::winograd {

inline constexpr std::int64_t tile = 4;           ///< Results a tile is wide and high.
inline constexpr std::int64_t points = 36;        ///< Products of a tile: (4 + 3 - 1)^2.
inline constexpr std::int64_t channel_step = 16;  ///< Channels are a multiple of this.

/// Tiles [first, first + count) of a frame's result, row by row.
struct TileRun {
  std::int64_t height = 0, width = 0;  ///< Of the result.
  std::int64_t seen = 0, above = 0;    ///< Rows of the frame, doubled if it is; of these, those above the first result.
  std::int64_t first = 0, count = 0;
  std::int64_t columns() const { return (width + tile - 1) / tile; }
  std::int64_t all() const { return (height + tile - 1) / tile * columns(); }
};

/// Where transformed numbers go: point p of row r at `to + p * plane + r * row`.
struct Planes {
  float* to = nullptr;
  std::int64_t plane = 0, row = 0;
};

/// One row a tile, `channels` numbers from its place on. `frame` is (h, w, channels), zeros beyond it; with `doubled`
/// each of its pixels stands for 2x2 of the result's. `zeros` holds `channels` zeros.
void transform_frame(const float* frame, bool doubled, std::int64_t channels, const float* zeros, const TileRun& tiles,
                     const Planes& to);
/// One row of `outputs` numbers a channel, for channels [begin, end); `weight` is (3, 3, channels, outputs).
void transform_weight(const float* weight, std::int64_t channels, std::int64_t outputs, std::int64_t begin,
                      std::int64_t end, const Planes& to);
/// `sums` holds one row of `channels` numbers a tile for each point, planes `plane` apart; `bias` may be null. `frame`
/// (height, width, channels) is overwritten, or with `add` added to.
void transform_sums(const float* sums, std::int64_t plane, std::int64_t channels, const float* bias, bool add,
                    const TileRun& tiles, float* frame);

}  // namespace uwv::model::winograd
