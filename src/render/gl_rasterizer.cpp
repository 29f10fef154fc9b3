// SPDX-License-Identifier: Apache-2.0
#include "uwv/render/gl_rasterizer.h"

#include <algorithm>
#include <cmath>

#include "render/gl_path.h"
#include "render/gl_state_guard.h"
#include "uwv/core/depth.h"

namespace uwv {
namespace {

void check_target(const Camera& target) {
  const Size size = target.size;
  require(size.width > 0 && size.height > 0 && size.width <= 65535 && size.height <= 65535,
          "a target of {}x{} pixels is outside 1..65535 on a side", size.width, size.height);
}

/// L_max of SoftSplatOptions: one cheap pass here saves a reduction, with its wait, on the GPU.
float largest_log_depth(const PointGrid& points, const WarpMap& map) {
  const auto& [a0, a1, a2] = map.a[2];
  float largest = 0;
  for (int y = 0; y < points.camera.size.height; ++y) {
    const float* depth = points.depth->row(y);
    const float row = a1 * static_cast<float>(y) + a2;
    for (int x = 0; x < points.camera.size.width; ++x) {
      const float z = depth[x] * (a0 * static_cast<float>(x) + row) + map.b[2];
      largest = depth[x] > 0 && z > largest ? z : largest;
    }
  }
  return std::log(1.0F + std::min(largest, 1000.0F));
}

std::unique_ptr<GlPath> make_path(const GlApi& gl, GlOptions::Path path) {
  if (path == GlOptions::Path::automatic) path = gl.compute ? GlOptions::Path::compute : GlOptions::Path::sprites;
  return path == GlOptions::Path::compute ? make_compute_path(gl) : make_sprite_path(gl);
}

class GlRasterizer final : public Rasterizer {
 public:
  GlRasterizer(std::unique_ptr<GlContext> context, GlOptions options)
      : context_(std::move(context)), gl_(context_->api()) {
    const GlCurrent current(*context_);
    const GlStateGuard guard(gl_);
    path_ = make_path(gl_, options.path);
    inputs_ = std::make_unique<Inputs>();
    check_gl(gl_, "preparing shaders");
  }

  ~GlRasterizer() override {
    const GlCurrent current(*context_);
    path_.reset();
    inputs_.reset();
  }

  std::string name() const override { return fmt::format("gl ({}, {})", context_->renderer(), path_->name()); }

  void zbuffer(const PointGrid& points, const Camera& target, const FootprintOptions& options, ZBuffer& out) override {
    options.check();
    GlJob job = describe(points, target);
    job.footprint = options;
    run(points, job, nullptr, "drawing a z-buffer", [&] {
      out.winner.resize(target.size);
      out.depth.resize(target.size);
      path_->zbuffer(job, out);
    });
  }

  void coverage(const PointGrid& points, const Camera& target, const FootprintOptions& options,
                ValidityMask& out) override {
    options.check();
    GlJob job = describe(points, target);
    job.footprint = options;
    run(points, job, nullptr, "drawing coverage", [&] {
      out.resize(target.size);
      path_->coverage(job, out);
    });
  }

  void soft_splat(const PointGrid& points, const ImageRgbF* colour, const Camera& target,
                  const SoftSplatOptions& options, SoftSplat& out) override {
    GlJob job = describe(points, target);
    require(colour == nullptr || colour->size() == job.source, "the colours do not have the grid's size {}x{}",
            job.source.width, job.source.height);
    job.has_slopes = false;
    job.has_colour = colour != nullptr;
    job.sharpness = options.sharpness;
    job.log_depth_max = options.log_depth_max > 0 ? options.log_depth_max : largest_log_depth(points, job.map);
    run(points, job, colour, "drawing a soft splat", [&] {
      out.colour.resize(colour == nullptr ? Size{} : target.size);
      out.depth.resize(target.size);
      out.valid.resize(target.size);
      path_->soft_splat(job, out);
    });
  }

 private:
  struct Inputs {
    GlRaster depth, slopes, colour;
  };

  static GlJob describe(const PointGrid& points, const Camera& target) {
    points.check();
    require(points.cells == nullptr, "points that stand for cells of pixels are drawn by the CPU renderer only");
    check_target(target);
    GlJob job;
    job.map = WarpMap::between(points.camera, target);
    job.source = points.camera.size;
    job.target = target.size;
    job.has_slopes = points.slopes != nullptr;
    return job;
  }

  template <class Draw>
  void run(const PointGrid& points, const GlJob& job, const ImageRgbF* colour, std::string_view step,
           const Draw& draw) {
    const GlCurrent current(*context_);
    const GlStateGuard guard(gl_);
    check_source(job);
    path_->check_limits(job);
    upload(points, job, colour);
    draw();
    check_gl(gl_, step);
  }

  void check_source(const GlJob& job) const {
    const int largest = gl_.integer(GL_MAX_TEXTURE_SIZE);
    if (std::max(job.source.width, job.source.height) > largest)
      fail(ErrorCode::backend_missing,
           "this OpenGL driver's textures are at most {0}x{0} pixels, the source is {1}x{2}; use --renderer cpu",
           largest, job.source.width, job.source.height);
  }

  void upload(const PointGrid& points, const GlJob& job, const ImageRgbF* colour) {
    inputs_->depth.allocate(gl_, depth_unit, job.source, GL_R32F, GL_RED, GL_FLOAT);
    inputs_->depth.upload(gl_, kept_depth(points).data());
    if (job.has_slopes) {
      inputs_->slopes.allocate(gl_, slope_unit, job.source, GL_RG32F, GL_RG, GL_FLOAT);
      inputs_->slopes.upload(gl_, points.slopes->data());
    }
    if (colour != nullptr) {
      inputs_->colour.allocate(gl_, colour_unit, job.source, GL_RGB32F, GL_RGB, GL_FLOAT);
      inputs_->colour.upload(gl_, colour->data());
    }
  }

  /// The mask goes into the depth, where 0 means "no point" already: one texture fewer to send and to fetch.
  const DepthMap& kept_depth(const PointGrid& points) {
    if (points.keep == nullptr) return *points.depth;
    masked_.resize(points.depth->size());
    std::transform(points.depth->pixels().begin(), points.depth->pixels().end(), points.keep->data(), masked_.data(),
                   [](float depth, std::uint8_t keep) { return keep != 0 ? depth : 0; });
    return masked_;
  }

  std::unique_ptr<GlContext> context_;
  const GlApi& gl_;
  std::unique_ptr<GlPath> path_;
  std::unique_ptr<Inputs> inputs_;
  DepthMap masked_;
};

}  // namespace

std::string_view to_string(GlOptions::Path path) {
  switch (path) {
    case GlOptions::Path::automatic: return "auto";
    case GlOptions::Path::sprites: return "sprites";
    case GlOptions::Path::compute: return "compute";
  }
  return "unknown";
}

GlOptions::Path parse_gl_path(std::string_view name) {
  for (const GlOptions::Path path : {GlOptions::Path::automatic, GlOptions::Path::sprites, GlOptions::Path::compute})
    if (to_string(path) == name) return path;
  fail(ErrorCode::value_invalid, "'{}' is no way to draw with OpenGL; auto, sprites or compute is wanted", name);
}

std::unique_ptr<Rasterizer> make_gl_rasterizer(std::unique_ptr<GlContext> context, GlOptions options) {
  require(context != nullptr, "the OpenGL renderer needs a context");
  return std::make_unique<GlRasterizer>(std::move(context), options);
}

}  // namespace uwv
