// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "render/kernel_chain.h"
#include "render/surface.h"

namespace uwv::detail {
namespace {

class SoftChain final : public KernelChain {
 public:
  SoftChain(Rasterizer& rasterizer, ThreadPool& pool, const OcclusionOptions& options)
      : rasterizer_(rasterizer), pool_(pool), options_(options) {}

  void first(const PointGrid& points, const Camera& target) override {
    rasterizer_.soft_splat(points, nullptr, target, options_.soft_splat, first_);
  }

  void first_mask(ValidityMask& out) const override { out = first_.valid; }

  void come_back(const PointGrid& points, const Camera& target, const ValidityMask* exclude,
                 ValidityMask& second) override {
    if (exclude != nullptr)
      std::transform(first_.depth.pixels().begin(), first_.depth.pixels().end(), exclude->pixels().begin(),
                     first_.depth.pixels().begin(), [](float z, std::uint8_t out) { return out != 0 ? 0.0F : z; });
    if (options_.visibility == Visibility::ztest) {
      const SlopeMap facing(target.size);
      visible_by_ztest(points, target, first_.depth, facing, options_.tolerance(), pool_, second);
      return;
    }
    rasterizer_.soft_splat({target, &first_.depth, nullptr, nullptr}, nullptr, points.camera, options_.soft_splat,
                           back_);
    second = back_.valid;
    if (options_.tolerance() > 0)
      for (int y = 0; y < second.height(); ++y)
        for (int x = 0; x < second.width(); ++x) {
          const float own = (*points.depth)(x, y);
          second(x, y) &= std::abs(back_.depth(x, y) - own) <= options_.tolerance() * own;
        }
  }

  void coverage(const PointGrid& points, const Camera& target, ValidityMask& out) override {
    rasterizer_.soft_splat(points, nullptr, target, options_.soft_splat, back_);
    out = back_.valid;
  }

  // Every point adds to a soft splat, the hidden ones too, and the first one has no colour.
  bool draw(const SourceFrame& source, const PointGrid& kept, const Camera& target, bool) override {
    to_float(*source.colour);
    rasterizer_.soft_splat(kept, &colour_, target, options_.soft_splat, final_);
    return true;
  }

  void colour(const SourceFrame&, const PointGrid&, const Camera& target, RenderedFrame& out) override {
    out.colour.resize(target.size);
    out.depth.resize(target.size);
    const auto byte = [](float v) { return static_cast<std::uint8_t>(std::clamp(v, 0.0F, 1.0F) * 255.0F + 0.5F); };
    pool_.for_ranges(0, target.size.height, 16, [&](int from, int to) {
      for (int y = from; y < to; ++y) {
        std::transform(final_.colour.row(y), final_.colour.row(y) + target.size.width, out.colour.row(y),
                       [&](const RgbF& c) {
                         return Rgb8{byte(c.r), byte(c.g), byte(c.b)};
                       });
        std::copy_n(final_.depth.row(y), target.size.width, out.depth.row(y));
      }
    });
    out.valid = final_.valid;
  }

 private:
  void to_float(const ImageRgb& colour) {
    colour_.resize(colour.size());
    pool_.for_ranges(0, colour.height(), 16, [&](int from, int to) {
      for (int y = from; y < to; ++y)
        std::transform(colour.row(y), colour.row(y) + colour.width(), colour_.row(y), [](const Rgb8& c) {
          return RgbF{static_cast<float>(c.r) / 255.0F, static_cast<float>(c.g) / 255.0F,
                      static_cast<float>(c.b) / 255.0F};
        });
    });
  }

  Rasterizer& rasterizer_;
  ThreadPool& pool_;
  const OcclusionOptions& options_;
  ImageRgbF colour_;
  SoftSplat first_, back_, final_;
};

}  // namespace

std::unique_ptr<KernelChain> make_soft_chain(Rasterizer& rasterizer, ThreadPool& pool,
                                             const OcclusionOptions& options) {
  return std::make_unique<SoftChain>(rasterizer, pool, options);
}

}  // namespace uwv::detail
