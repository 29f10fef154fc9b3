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
    DepthMap depth = first_.depth;
    if (exclude != nullptr)
      std::transform(depth.pixels().begin(), depth.pixels().end(), exclude->pixels().begin(), depth.pixels().begin(),
                     [](float z, std::uint8_t out) { return out != 0 ? 0.0F : z; });
    if (options_.visibility == Visibility::ztest) {
      const SlopeMap facing(depth.size());
      visible_by_ztest(points, target, depth, facing, options_.tolerance(), pool_, second);
      return;
    }
    rasterizer_.soft_splat({target, &depth, nullptr, nullptr}, nullptr, points.camera, options_.soft_splat, back_);
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

  // Every point adds to a soft splat, the hidden ones too.
  bool first_is_final(const ValidityMask&) const override { return false; }

  void draw(const SourceFrame& source, const PointGrid& kept, const Camera& target, bool, RenderedFrame& out) override {
    to_float(*source.colour);
    rasterizer_.soft_splat(kept, &colour_, target, options_.soft_splat, final_);
    out.colour.resize(target.size);
    const auto to_byte = [](float v) { return static_cast<std::uint8_t>(std::clamp(v, 0.0F, 1.0F) * 255.0F + 0.5F); };
    std::transform(final_.colour.pixels().begin(), final_.colour.pixels().end(), out.colour.pixels().begin(),
                   [&](const RgbF& c) {
                     return Rgb8{to_byte(c.r), to_byte(c.g), to_byte(c.b)};
                   });
    out.depth = final_.depth;
    out.valid = final_.valid;
  }

 private:
  void to_float(const ImageRgb& colour) {
    colour_.resize(colour.size());
    const auto unit = [](std::uint8_t v) { return static_cast<float>(v) / 255.0F; };
    std::transform(colour.pixels().begin(), colour.pixels().end(), colour_.pixels().begin(), [&](const Rgb8& c) {
      return RgbF{unit(c.r), unit(c.g), unit(c.b)};
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
