// SPDX-License-Identifier: Apache-2.0
// What one thread of the CPU renderer draws into.
#pragma once

#include <algorithm>
#include <vector>

#include "render/footprint.h"

namespace uwv::detail {

/// One thread's picture: `empty` everywhere between uses, so that only rows that were drawn on need clearing. Behind it
/// lie spare pixels for points that draw nothing (see Corners).
template <class Pixel>
struct Layer {
  Size size;
  std::vector<Pixel, CacheAligned<Pixel>> pixels;
  int first_row = 0, last_row = -1;  ///< Rows drawn on since the last merge.

  void prepare(Size wanted, Pixel empty) {
    if (size == wanted) return;
    size = wanted;
    pixels.assign(size.pixels() + block_size, empty);
    forget_rows();
  }
  Pixel* row(int y) { return pixels.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width); }
  void touch(int y0, int y1) {
    first_row = std::min(first_row, y0);
    last_row = std::max(last_row, y1);
  }
  bool touched(int y) const { return y >= first_row && y <= last_row; }
  void forget_rows() {
    first_row = size.height;
    last_row = -1;
  }
};

/// Calls touch(i, pixel) for each pixel that each point of a block covers, at least once.
template <class Pixel, class Touch>
void for_covered(Layer<Pixel>& layer, const Footprints& f, const BlockExtent& extent, int count, const Touch& touch) {
  if (extent.wider <= 1 && extent.taller <= 1) {
    // Nearly all blocks. Corner by corner over all points, without jumps: what a processor cannot predict, and one
    // point waiting for its neighbour's pixel, would cost more than touching a pixel twice.
    Corners corners;
    corners_of_block(f, layer.size, count, corners);
    if constexpr (sizeof(Pixel) == 8)
      for (std::size_t i = 0; i < static_cast<std::size_t>(count); i += 8)
        __builtin_prefetch(layer.pixels.data() + corners.index[2][i] + layer.size.width, 1);
    for (std::size_t corner = 0; corner < 4; ++corner) {
      if ((corner & 1) > static_cast<std::size_t>(extent.wider)) continue;
      if ((corner >> 1) > static_cast<std::size_t>(extent.taller)) continue;
      for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
        touch(i, layer.pixels[corners.index[corner][i]]);
    }
    return;
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
    for (int y = f.y0[i]; y <= f.y1[i]; ++y) {
      Pixel* row = layer.row(y);
      for (int x = f.x0[i]; x <= f.x1[i]; ++x) touch(i, row[x]);
    }
}

}  // namespace uwv::detail
