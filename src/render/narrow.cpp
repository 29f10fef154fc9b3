// SPDX-License-Identifier: Apache-2.0
#include "render/narrow.h"

#include <atomic>

namespace uwv::detail {
namespace {

bool dropped(std::uint32_t code, const ValidityMask& keep) {
  return code != PointCode::none && keep(PointCode::x(code), PointCode::y(code)) == 0;
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
    for (int y = from * TileMap::side; y < std::min(size.height, to * TileMap::side); ++y) {
      std::uint32_t* winner = zbuffer.winner.row(y);
      float* depth = zbuffer.depth.row(y);
      for (int x = 0; x < size.width; ++x) {
        if (!dropped(winner[x], *points.keep)) continue;
        winner[x] = PointCode::none;
        depth[x] = 0;
        vacant.mark(x, y);
        ++count;
      }
    }
    total += count;
  });
  return total;
}

}  // namespace uwv::detail
