// SPDX-License-Identifier: Apache-2.0
// Taking points out of a z-buffer: only the pixels they had won change.
#pragma once

#include "render/footprint.h"

namespace uwv::detail {

/// Which 16x16 tiles of a picture hold something.
class TileMap {
 public:
  static constexpr int side = 16;
  void clear(Size picture);
  /// Marks the tile of pixel (x, y). Threads may mark at once when they stay in different rows of tiles.
  void mark(int x, int y) { tiles_(x / side, y / side) = 1; }
  /// True when a tile that overlaps the box is marked; the box is inside the picture and not empty.
  bool any(const PixelBox& box) const;

 private:
  Image<std::uint8_t> tiles_;
};

/// Marks the tiles that hold a pixel which shows nothing.
void find_empty(const ZBuffer& zbuffer, ThreadPool& pool, TileMap& vacant);

/// Pixels of `zbuffer` won by points that `points` does not keep.
std::size_t count_dropped_winners(const PointGrid& points, const ZBuffer& zbuffer);

/// Empties those pixels, marks their tiles in `vacant`, and returns how many they are.
std::size_t forget_dropped_winners(const PointGrid& points, ThreadPool& pool, ZBuffer& zbuffer, TileMap& vacant);

}  // namespace uwv::detail
