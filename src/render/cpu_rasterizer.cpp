// SPDX-License-Identifier: Apache-2.0
// The CPU renderer. Each thread draws a share of the points into a picture of its own; the pictures are then merged by
// taking the smallest key per pixel. A key holds depth above and point code below, so the merged picture does not
// depend on the number of threads, and "nearest wins, ties go to the lower code" is one integer comparison.
#include <array>
#include <bit>
#include <limits>
#include <vector>

#include "render/cells.h"
#include "render/cpu_soft_splat.h"
#include "render/footprint.h"
#include "render/layer.h"
#include "render/narrow.h"
#include "render/point_blocks.h"
#include "render/shared_rows.h"
#include "uwv/render/rasterizer.h"

namespace uwv {
namespace {

using Key = std::uint64_t;
using detail::BlockOfPoints;
using detail::GridBlocks;
using detail::Layer;
using detail::SharedRows;
using detail::SurfaceBlocks;
constexpr Key no_key = std::numeric_limits<Key>::max();

// Positive floats order like their bit patterns.
Key key_of(float depth, std::uint32_t code) { return Key{std::bit_cast<std::uint32_t>(depth)} << 32 | code; }

void check_target(const Camera& target) {
  require(target.size.width > 0 && target.size.height > 0 && target.size.width <= 65535 && target.size.height <= 65535,
          "a target of {}x{} pixels is outside 1..65535 on a side", target.size.width, target.size.height);
}

struct DrawNearest {
  void operator()(Layer<Key>& layer, const detail::Footprints& f, const detail::BlockExtent& extent, int count, int x,
                  int y) const {
    alignas(64) std::array<Key, detail::block_size> keys;
    for (int i = 0; i < count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      keys[at] = key_of(f.depth[at], PointCode::pack(x + i, y));
    }
    for_covered(layer, f, extent, count,
                [&keys](std::size_t i, Key& pixel) { pixel = keys[i] < pixel ? keys[i] : pixel; });
  }
  static void put(Key& pixel, float depth, std::uint32_t code) { pixel = std::min(pixel, key_of(depth, code)); }
};

/// 1 = not covered, so that merging by minimum serves both kinds of layer.
struct DrawCovered {
  void operator()(Layer<std::uint8_t>& layer, const detail::Footprints& f, const detail::BlockExtent& extent, int count,
                  int, int) const {
    for_covered(layer, f, extent, count, [](std::size_t, std::uint8_t& pixel) { pixel = 0; });
  }
  static void put(std::uint8_t& pixel, float, std::uint32_t) { pixel = 0; }
};

class CpuRasterizer final : public Rasterizer {
 public:
  explicit CpuRasterizer(ThreadPool& pool) : pool_(pool) {}

  std::string name() const override { return "cpu"; }

  void zbuffer(const PointGrid& points, const Camera& target, const FootprintOptions& options, ZBuffer& out) override {
    points.check();
    const Size source = points.camera.size;
    out.reach.resize(blocks_per_row(source.width) * static_cast<std::size_t>(source.height));
    draw(points.camera, GridBlocks{points}, target, options, key_layers_, no_key, DrawNearest{},
         {.note = out.reach.data()});
    out.winner.resize(target.size);
    out.depth.resize(target.size);
    merge(key_layers_, target.size, no_key, [&](int y, const Key* keys) {
      std::uint32_t* winner = out.winner.row(y);
      float* depth = out.depth.row(y);
      for (int x = 0; x < target.size.width; ++x) {
        winner[x] = static_cast<std::uint32_t>(keys[x]);  // no_key's low half is PointCode::none
        depth[x] = keys[x] == no_key ? 0.0F : std::bit_cast<float>(static_cast<std::uint32_t>(keys[x] >> 32));
      }
    });
  }

  std::size_t narrow(const PointGrid& points, const Camera& target, const FootprintOptions& options,
                     ZBuffer& zbuffer) override {
    points.check();
    const Size source = points.camera.size;
    if (zbuffer.reach.size() != blocks_per_row(source.width) * static_cast<std::size_t>(source.height))
      return Rasterizer::narrow(points, target, options, zbuffer);  // another renderer's
    const std::size_t dropped = detail::forget_dropped_winners(points, pool_, zbuffer, vacant_);
    if (dropped == 0) return 0;
    draw(points.camera, GridBlocks{points}, target, options, key_layers_, no_key, DrawNearest{},
         {.wanted = &vacant_, .reach = zbuffer.reach.data()});
    // No point of the superset reached the pixels that were empty before, so every empty pixel may take what came.
    take_where_empty(target.size, zbuffer);
    return dropped;
  }

  void fill(const PointGrid& points, const Camera& target, const FootprintOptions& options, ZBuffer& zbuffer) override {
    points.check();
    detail::find_empty(zbuffer, pool_, vacant_);
    draw(points.camera, GridBlocks{points}, target, options, key_layers_, no_key, DrawNearest{}, {.wanted = &vacant_});
    take_where_empty(target.size, zbuffer);
    zbuffer.reach.clear();  // these points may reach further
  }

  void coverage(const PointGrid& points, const Camera& target, const FootprintOptions& options,
                ValidityMask& out) override {
    points.check();
    cover(points.camera, GridBlocks{points}, target, options, out);
  }

  bool come_back(const PointGrid& points, const Camera& target, const ZBuffer& zbuffer, const FootprintOptions& options,
                 ValidityMask& out) override {
    points.check();
    require(zbuffer.winner.size() == target.size, "the z-buffer is {}x{}, its camera {}x{}", zbuffer.winner.width(),
            zbuffer.winner.height(), target.size.width, target.size.height);
    cover(target, SurfaceBlocks(points, target, zbuffer), points.camera, options, out);
    return true;
  }

  void soft_splat(const PointGrid& points, const ImageRgbF* colour, const Camera& target,
                  const SoftSplatOptions& options, SoftSplat& out) override {
    points.check();
    check_target(target);
    detail::soft_splat(points, colour, target, options, pool_, soft_scratch_, out);
  }

 private:
  /// What decides which blocks are drawn, and what is noted about them; either may be null.
  struct Blocks {
    const detail::TileMap* wanted = nullptr;  ///< Draw at least every point that covers a pixel marked here, ..
    const PixelBox* reach = nullptr;          ///< .. knowing, if not null, that no block covers more than this.
    PixelBox* note = nullptr;                 ///< What each block covers.
  };

  /// Merges the key layers into the pixels of `zbuffer` that show nothing.
  void take_where_empty(Size size, ZBuffer& zbuffer) {
    merge(key_layers_, size, no_key, [&](int y, const Key* keys) {
      std::uint32_t* winner = zbuffer.winner.row(y);
      float* depth = zbuffer.depth.row(y);
      for (int x = 0; x < size.width; ++x) {
        const bool take = (winner[x] == PointCode::none) & (keys[x] != no_key);
        winner[x] = take ? static_cast<std::uint32_t>(keys[x]) : winner[x];
        depth[x] = take ? std::bit_cast<float>(static_cast<std::uint32_t>(keys[x] >> 32)) : depth[x];
      }
    });
  }

  template <class Source>
  void cover(const Camera& camera, const Source& source, const Camera& target, const FootprintOptions& options,
             ValidityMask& out) {
    draw(camera, source, target, options, hit_layers_, std::uint8_t{1}, DrawCovered{}, {});
    out.resize(target.size);
    merge(hit_layers_, target.size, std::uint8_t{1}, [&](int y, const std::uint8_t* missed) {
      std::uint8_t* row = out.row(y);
      for (int x = 0; x < target.size.width; ++x) row[x] = missed[x] ^ 1U;
    });
  }

  /// Draws the points of `source`, which belong to `camera`, into the layers.
  template <class Source, class Pixel, class Draw>
  void draw(const Camera& camera, const Source& source, const Camera& target, const FootprintOptions& options,
            std::vector<Layer<Pixel>>& layers, Pixel empty, const Draw& draw_block, const Blocks& blocks) {
    check_target(target);
    options.check();
    const WarpMap map = WarpMap::between(camera, target);
    const detail::FootprintLimits limits(target.size, options);
    const int width = camera.size.width, height = camera.size.height;
    layers.resize(static_cast<std::size_t>(std::min(pool_.size(), height)));
    const int parts = static_cast<int>(layers.size());
    std::vector<SharedRows> shares;
    for (int first = 0; first < parts; first += 2) {
      const auto row = [&](int part) { return static_cast<int>(static_cast<long>(height) * part / parts); };
      shares.emplace_back(row(first), row(std::min(first + 2, parts)));
    }
    pool_.run(parts, [&](int part) {
      Layer<Pixel>& layer = layers[static_cast<std::size_t>(part)];
      layer.prepare(target.size, empty);
      Source own = source;
      shares[static_cast<std::size_t>(part / 2)].for_rows(
          part % 2 == 0, [&](int y) { draw_row(own, map, limits, width, y, layer, draw_block, blocks); });
    });
  }

  template <class Source, class Pixel, class Draw>
  static void draw_row(Source& source, const WarpMap& map, const detail::FootprintLimits& limits, int width, int y,
                       Layer<Pixel>& layer, const Draw& draw_block, const Blocks& blocks) {
    detail::Footprints footprints;
    std::size_t block = static_cast<std::size_t>(y) * blocks_per_row(width);
    for (int x = 0; x < width; x += detail::block_size, ++block) {
      if (blocks.reach != nullptr && (blocks.reach[block].empty() || !blocks.wanted->any(blocks.reach[block])))
        continue;
      const int count = std::min(detail::block_size, width - x);
      const BlockOfPoints points = source.at(x, y, count);
      if (points.cells != nullptr)
        detail::footprints_of_cells(map, x, y, count, points, limits, footprints);
      else
        detail::footprints_of_block(map, x, y, count, points.depth, points.slopes, points.keep, limits, footprints);
      const detail::BlockExtent extent = detail::extent_of_block(footprints, count);
      if (blocks.note != nullptr) blocks.note[block] = extent.box;
      if (extent.box.empty() || (blocks.wanted != nullptr && !blocks.wanted->any(extent.box))) continue;
      layer.touch(extent.box.y0, extent.box.y1);
      if (points.cells != nullptr)
        detail::for_cell_pixels(
            map, x, y, count, points, footprints,
            [&layer](int u, int v, float depth, std::uint32_t code) { Draw::put(layer.row(v)[u], depth, code); });
      else
        draw_block(layer, footprints, extent, count, x, y);
    }
  }

  static std::size_t blocks_per_row(int width) {
    return (static_cast<std::size_t>(width) + detail::block_size - 1) / detail::block_size;
  }

  /// Calls emit(y, row) with the smallest value of all layers in each row, and empties the layers again.
  template <class Pixel, class Emit>
  void merge(std::vector<Layer<Pixel>>& layers, Size size, Pixel empty, const Emit& emit) {
    pool_.for_ranges(0, size.height, 16, [&](int from, int to) {
      const std::vector<Pixel> untouched(static_cast<std::size_t>(size.width), empty);
      for (int y = from; y < to; ++y) {
        Pixel* merged = nullptr;
        for (Layer<Pixel>& layer : layers) {
          if (!layer.touched(y)) continue;
          Pixel* row = layer.row(y);
          if (merged == nullptr) {
            merged = row;
            continue;
          }
          for (int x = 0; x < size.width; ++x) merged[x] = std::min(merged[x], row[x]);
          std::fill_n(row, size.width, empty);
        }
        emit(y, merged != nullptr ? merged : untouched.data());
        if (merged != nullptr) std::fill_n(merged, size.width, empty);
      }
    });
    for (Layer<Pixel>& layer : layers) layer.forget_rows();
  }

  ThreadPool& pool_;
  std::vector<Layer<Key>> key_layers_;
  std::vector<Layer<std::uint8_t>> hit_layers_;
  detail::TileMap vacant_;
  detail::SoftScratch soft_scratch_;
};

}  // namespace

void FootprintOptions::check() const {
  require(point_size > 0 && point_size <= 16, "point_size {} is outside (0, 16]", point_size);
  require(min_footprint >= 1 && min_footprint <= max_footprint, "min_footprint {} is outside 1..max_footprint = {}",
          min_footprint, max_footprint);
  require(max_footprint >= 1 && max_footprint <= 255, "max_footprint {} is outside 1..255", max_footprint);
}

bool Rasterizer::come_back(const PointGrid&, const Camera&, const ZBuffer&, const FootprintOptions&, ValidityMask&) {
  return false;
}

void Rasterizer::fill(const PointGrid& points, const Camera& target, const FootprintOptions& options, ZBuffer& in_out) {
  ZBuffer added;
  zbuffer(points, target, options, added);
  for (std::size_t i = 0; i < in_out.winner.size().pixels(); ++i)
    if (in_out.winner.data()[i] == PointCode::none) {
      in_out.winner.data()[i] = added.winner.data()[i];
      in_out.depth.data()[i] = added.depth.data()[i];
    }
}

std::size_t Rasterizer::narrow(const PointGrid& points, const Camera& target, const FootprintOptions& options,
                               ZBuffer& in_out) {
  points.check();
  const std::size_t dropped = detail::count_dropped_winners(points, in_out);
  if (dropped > 0) zbuffer(points, target, options, in_out);
  return dropped;
}

std::unique_ptr<Rasterizer> make_cpu_rasterizer(ThreadPool& pool) { return std::make_unique<CpuRasterizer>(pool); }

}  // namespace uwv
