// SPDX-License-Identifier: Apache-2.0
// The CPU renderer. Each thread draws a share of the points into a picture of its own; the pictures are then merged by
// taking the smallest key per pixel. A key holds depth above and point code below, so the merged picture does not
// depend on the number of threads, and "nearest wins, ties go to the lower code" is one integer comparison.
#include <bit>
#include <limits>
#include <vector>

#include "render/cpu_soft_splat.h"
#include "render/footprint.h"
#include "uwv/render/rasterizer.h"

namespace uwv {
namespace {

using Key = std::uint64_t;
constexpr Key no_key = std::numeric_limits<Key>::max();

// Positive floats order like their bit patterns.
Key key_of(float depth, std::uint32_t code) { return Key{std::bit_cast<std::uint32_t>(depth)} << 32 | code; }

/// One thread's picture: `no_key`/0 everywhere between uses, so that only rows that were drawn on need clearing.
template <class Pixel>
struct Layer {
  Image<Pixel> pixels;
  int first_row = 0, last_row = -1;  ///< Rows drawn on since the last merge.

  void prepare(Size size, Pixel empty) {
    if (pixels.size() == size) return;
    pixels = Image<Pixel>(size, empty);
    first_row = size.height;
    last_row = -1;
  }
  void touch(int y0, int y1) {
    first_row = std::min(first_row, y0);
    last_row = std::max(last_row, y1);
  }
  bool touched(int y) const { return y >= first_row && y <= last_row; }
  void forget_rows() {
    first_row = pixels.height();
    last_row = -1;
  }
};

void check_target(const Camera& target) {
  require(target.size.width > 0 && target.size.height > 0 && target.size.width <= 65535 && target.size.height <= 65535,
          "a target of {}x{} pixels is outside 1..65535 on a side", target.size.width, target.size.height);
}

class CpuRasterizer final : public Rasterizer {
 public:
  explicit CpuRasterizer(ThreadPool& pool) : pool_(pool) {}

  std::string name() const override { return "cpu"; }

  void zbuffer(const PointGrid& points, const Camera& target, const FootprintOptions& options, ZBuffer& out) override {
    draw(points, target, options, key_layers_, no_key,
         [](Layer<Key>& layer, const detail::Footprints& f, int i, int x, int y) {
           const auto at = static_cast<std::size_t>(i);
           const Key key = key_of(f.depth[at], PointCode::pack(x, y));
           for (int ty = f.y0[at]; ty <= f.y1[at]; ++ty) {
             Key* row = layer.pixels.row(ty);
             for (int tx = f.x0[at]; tx <= f.x1[at]; ++tx)
               if (key < row[tx]) row[tx] = key;
           }
         });
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

  void coverage(const PointGrid& points, const Camera& target, const FootprintOptions& options,
                ValidityMask& out) override {
    // 1 = not covered, so that merging by minimum serves both kinds of layer.
    draw(points, target, options, hit_layers_, std::uint8_t{1},
         [](Layer<std::uint8_t>& layer, const detail::Footprints& f, int i, int, int) {
           const auto at = static_cast<std::size_t>(i);
           for (int ty = f.y0[at]; ty <= f.y1[at]; ++ty) {
             std::uint8_t* row = layer.pixels.row(ty);
             for (int tx = f.x0[at]; tx <= f.x1[at]; ++tx) row[tx] = 0;
           }
         });
    out.resize(target.size);
    merge(hit_layers_, target.size, std::uint8_t{1}, [&](int y, const std::uint8_t* missed) {
      std::uint8_t* row = out.row(y);
      for (int x = 0; x < target.size.width; ++x) row[x] = missed[x] ^ 1U;
    });
  }

  void soft_splat(const PointGrid& points, const ImageRgbF* colour, const Camera& target,
                  const SoftSplatOptions& options, SoftSplat& out) override {
    points.check();
    check_target(target);
    detail::soft_splat(points, colour, target, options, pool_, soft_scratch_, out);
  }

 private:
  template <class Pixel, class Draw>
  void draw(const PointGrid& points, const Camera& target, const FootprintOptions& options,
            std::vector<Layer<Pixel>>& layers, Pixel empty, const Draw& draw_point) {
    points.check();
    check_target(target);
    options.check();
    const WarpMap map = WarpMap::between(points.camera, target);
    const detail::FootprintLimits limits(target.size, options);
    const Size size = points.camera.size;
    layers.resize(static_cast<std::size_t>(std::min(pool_.size(), size.height)));
    const int parts = static_cast<int>(layers.size());
    pool_.run(parts, [&](int part) {
      Layer<Pixel>& layer = layers[static_cast<std::size_t>(part)];
      layer.prepare(target.size, empty);
      const int from = static_cast<int>(static_cast<long>(size.height) * part / parts);
      const int to = static_cast<int>(static_cast<long>(size.height) * (part + 1) / parts);
      draw_rows(points, map, limits, from, to, layer, draw_point);
    });
  }

  template <class Pixel, class Draw>
  static void draw_rows(const PointGrid& points, const WarpMap& map, const detail::FootprintLimits& limits, int from,
                        int to, Layer<Pixel>& layer, const Draw& draw_point) {
    detail::Footprints footprints;
    const int width = points.camera.size.width;
    int first_row = std::numeric_limits<int>::max(), last_row = -1;
    for (int y = from; y < to; ++y) {
      for (int x = 0; x < width; x += detail::block_size) {
        const int count = std::min(detail::block_size, width - x);
        detail::footprints_of_block(map, x, y, count, points.depth->row(y) + x,
                                    points.slopes != nullptr ? points.slopes->row(y) + x : nullptr,
                                    points.keep != nullptr ? points.keep->row(y) + x : nullptr, limits, footprints);
        for (int i = 0; i < count; ++i) {
          const auto at = static_cast<std::size_t>(i);
          if (footprints.x1[at] < footprints.x0[at]) continue;
          first_row = std::min(first_row, footprints.y0[at]);
          last_row = std::max(last_row, footprints.y1[at]);
          draw_point(layer, footprints, i, x + i, y);
        }
      }
    }
    layer.touch(first_row, last_row);
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
          Pixel* row = layer.pixels.row(y);
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
  detail::SoftScratch soft_scratch_;
};

}  // namespace

void FootprintOptions::check() const {
  require(point_size > 0 && point_size <= 16, "point_size {} is outside (0, 16]", point_size);
  require(max_footprint >= 1 && max_footprint <= 255, "max_footprint {} is outside 1..255", max_footprint);
}

std::unique_ptr<Rasterizer> make_cpu_rasterizer(ThreadPool& pool) { return std::make_unique<CpuRasterizer>(pool); }

}  // namespace uwv
