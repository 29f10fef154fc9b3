// SPDX-License-Identifier: Apache-2.0
#include "render/narrow.h"

#include <atomic>

namespace uwv::detail {
namespace {

bool dropped(std::uint32_t code, const ValidityMask& keep) {
  return code != PointCode::none && keep(PointCode::x(code), PointCode::y(code)) == 0;
}

/// Any dropped winner among `count` pixels? Without a jump a pixel: there are few.
bool any_dropped(const std::uint32_t* winner, int count, const ValidityMask& keep) {
  const auto width = static_cast<std::size_t>(keep.width());
  const std::uint8_t* kept = keep.data();
  unsigned lost = 0;
  for (int x = 0; x < count; ++x) {
    const std::uint32_t code = winner[x];
    const bool hit = code != PointCode::none;
    const std::size_t at = hit ? (code >> 16) * width + (code & 0xFFFFU) : 0;
    lost |= static_cast<unsigned>(hit) & (kept[at] ^ 1U);
  }
  return lost != 0;
}

/// Empties the dropped pixels of (x, y) .. (x + count - 1, y), which share a tile.
std::size_t forget(const ValidityMask& keep, int x, int y, int count, ZBuffer& zbuffer, TileMap& vacant) {
  std::uint32_t* winner = zbuffer.winner.row(y) + x;
  float* depth = zbuffer.depth.row(y) + x;
  if (!any_dropped(winner, count, keep)) return 0;
  vacant.mark(x, y);
  std::size_t forgotten = 0;
  for (int i = 0; i < count; ++i) {
    if (!dropped(winner[i], keep)) continue;
    winner[i] = PointCode::none;
    depth[i] = 0;
    ++forgotten;
  }
  return forgotten;
}

}  // namespace

void TileMap::clear(Size picture) {
  tiles_.resize({(picture.width + side - 1) / side, (picture.height + side - 1) / side});
  tiles_.fill(0);
}

bool TileMap::any(const PixelBox& box) const {
  for (int y = box.y0 / side; y <= box.y1 / side; ++y)
    for (int x = box.x0 / side; x <= box.x1 / side; ++x)
      if (tiles_(x, y) != 0) return true;
  return false;
}

void find_empty(const ZBuffer& zbuffer, ThreadPool& pool, TileMap& vacant) {
  const Size size = zbuffer.winner.size();
  vacant.clear(size);
  pool.for_ranges(0, (size.height + TileMap::side - 1) / TileMap::side, 1, [&](int from, int to) {
    for (int y = from * TileMap::side; y < std::min(size.height, to * TileMap::side); ++y)
      for (int x = 0; x < size.width; x += TileMap::side) {
        const std::uint32_t* winner = zbuffer.winner.row(y) + x;
        if (std::find(winner, winner + std::min(TileMap::side, size.width - x), PointCode::none) !=
            winner + std::min(TileMap::side, size.width - x))
          vacant.mark(x, y);
      }
  });
}

std::size_t count_dropped_winners(const PointGrid& points, const ZBuffer& zbuffer) {
  if (points.keep == nullptr) return 0;
  return static_cast<std::size_t>(std::count_if(zbuffer.winner.pixels().begin(), zbuffer.winner.pixels().end(),
                                                [&](std::uint32_t code) { return dropped(code, *points.keep); }));
}

std::size_t forget_dropped_winners(const PointGrid& points, ThreadPool& pool, ZBuffer& zbuffer, TileMap& vacant) {
  const Size size = zbuffer.winner.size();
  vacant.clear(size);
  if (points.keep == nullptr) return 0;
  std::atomic<std::size_t> total{0};
  const int tile_rows = (size.height + TileMap::side - 1) / TileMap::side;
  pool.for_ranges(0, tile_rows, 1, [&](int from, int to) {
    std::size_t count = 0;
    for (int y = from * TileMap::side; y < std::min(size.height, to * TileMap::side); ++y)
      for (int x = 0; x < size.width; x += TileMap::side)
        count += forget(*points.keep, x, y, std::min(TileMap::side, size.width - x), zbuffer, vacant);
    total += count;
  });
  return total;
}

}  // namespace uwv::detail
