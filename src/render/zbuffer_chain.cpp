// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "render/kernel_chain.h"
#include "render/surface.h"

namespace uwv::detail {
namespace {

class ZBufferChain final : public KernelChain {
 public:
  ZBufferChain(Rasterizer& rasterizer, ThreadPool& pool, const OcclusionOptions& options)
      : rasterizer_(rasterizer), pool_(pool), options_(options), way_back_(options.footprint) {
    way_back_.point_size *= options.return_size;
  }

  void first(const PointGrid& points, const Camera& target) override {
    rasterizer_.zbuffer(points, target, options_.footprint, first_);
  }

  void first_mask(ValidityMask& out) const override {
    out.resize(first_.winner.size());
    std::transform(first_.winner.pixels().begin(), first_.winner.pixels().end(), out.pixels().begin(),
                   [](std::uint32_t code) { return static_cast<std::uint8_t>(code != PointCode::none); });
  }

  void come_back(const PointGrid& points, const Camera& target, const ValidityMask* exclude,
                 ValidityMask& second) override {
    const bool only_coverage = options_.visibility == Visibility::reproject && options_.tolerance() == 0;
    if (only_coverage && exclude == nullptr && rasterizer_.come_back(points, target, first_, way_back_, second)) return;
    surface_geometry(points, target, first_, pool_, surface_depth_, &surface_slopes_);
    if (exclude != nullptr)
      std::transform(surface_depth_.pixels().begin(), surface_depth_.pixels().end(), exclude->pixels().begin(),
                     surface_depth_.pixels().begin(), [](float z, std::uint8_t out) { return out != 0 ? 0.0F : z; });
    if (options_.visibility == Visibility::ztest) {
      visible_by_ztest(points, target, surface_depth_, surface_slopes_, options_.tolerance(), pool_, second);
      return;
    }
    const PointGrid seen{target, &surface_depth_, &surface_slopes_, nullptr};
    if (options_.tolerance() > 0) {
      rasterizer_.zbuffer(seen, points.camera, way_back_, returned_);
      keep_agreeing_depths(*points.depth, second);
    } else {
      rasterizer_.coverage(seen, points.camera, way_back_, second);
    }
  }

  void coverage(const PointGrid& points, const Camera& target, ValidityMask& out) override {
    rasterizer_.coverage(points, target, options_.footprint, out);
  }

  bool draw(const SourceFrame&, const PointGrid& kept, const Camera& target, bool after_first) override {
    bool drawn = true;
    if (after_first)
      drawn = rasterizer_.narrow(kept, target, options_.footprint, first_) > 0;
    else
      rasterizer_.zbuffer(kept, target, options_.footprint, first_);
    if (options_.fringe > 0.5F) {
      FootprintOptions wide = options_.footprint;
      wide.min_footprint = 2 * options_.fringe;
      wide.max_footprint = std::max(wide.max_footprint, wide.min_footprint);
      rasterizer_.fill(kept, target, wide, first_);
    }
    return drawn;
  }

  void colour(const SourceFrame& source, const PointGrid& kept, const Camera& target, RenderedFrame& out) override {
    if (options_.kernel == Kernel::resample)
      resampled_colour(kept, target, first_, *source.colour, pool_, out);
    else
      nearest_colour(first_, *source.colour, pool_, out);
  }

 private:
  void keep_agreeing_depths(const DepthMap& own, ValidityMask& second) const {
    second.resize(own.size());
    std::transform(own.pixels().begin(), own.pixels().end(), returned_.depth.pixels().begin(), second.pixels().begin(),
                   [tolerance = options_.tolerance()](float z, float back) {
                     return static_cast<std::uint8_t>(back > 0 && std::fabs(back - z) <= tolerance * z);
                   });
  }

  Rasterizer& rasterizer_;
  ThreadPool& pool_;
  const OcclusionOptions& options_;
  FootprintOptions way_back_;
  ZBuffer first_;  // the final rendering takes its place
  ZBuffer returned_;
  DepthMap surface_depth_;
  SlopeMap surface_slopes_;
};

}  // namespace

std::unique_ptr<KernelChain> make_zbuffer_chain(Rasterizer& rasterizer, ThreadPool& pool,
                                                const OcclusionOptions& options) {
  return std::make_unique<ZBufferChain>(rasterizer, pool, options);
}

}  // namespace uwv::detail
