// SPDX-License-Identifier: Apache-2.0
// The classic way: one point sprite per source pixel, drawn into a framebuffer with a 32-bit float depth buffer
// (nearest wins) or with additive blending (soft splat).
#include <algorithm>
#include <array>
#include <cmath>

#include "render/gl_path.h"

namespace uwv {
namespace {

// Depth buffers hold [0, 1]: depths up to max_depth are scaled by a power of two, which rounds nothing.
constexpr float scale = 0x1p40F;

class SpritePath final : public GlPath {
 public:
  explicit SpritePath(const GlApi& gl)
      : gl_(gl),
        nearest_(program("footprint.glsl", "nearest.vert", "nearest.frag")),
        coverage_(program("footprint.glsl", "nearest.vert", "coverage.frag")),
        soft_(program("soft.glsl", "soft.vert", "soft.frag")),
        framebuffer_(make_framebuffer(gl)),
        vertex_array_(make_vertex_array(gl)) {}

  const char* name() const override { return "sprites"; }

  void check_limits(const GlJob& job) const override {
    std::array<GLint, 2> viewport{};
    gl_.GetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport.data());
    const int largest = std::min({viewport[0], viewport[1], gl_.integer(GL_MAX_TEXTURE_SIZE)});
    if (std::max(job.target.width, job.target.height) > largest)
      fail(ErrorCode::backend_missing,
           "this OpenGL driver draws at most {0}x{0} pixels, {1}x{2} were asked for; use "
           "--renderer cpu",
           largest, job.target.width, job.target.height);
    std::array<float, 2> range{};
    gl_.GetFloatv(GL_POINT_SIZE_RANGE, range.data());
    if (std::ceil(job.footprint.max_footprint) > range[1])
      fail(ErrorCode::backend_missing,
           "max_footprint is {}, this OpenGL driver's sprites are at most {} pixels wide; "
           "choose a smaller max_footprint or --renderer cpu",
           job.footprint.max_footprint, range[1]);
  }

  void zbuffer(const GlJob& job, ZBuffer& out) override {
    winner_.allocate(gl_, scratch_unit, job.target, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT);
    depth_.allocate(gl_, scratch_unit, job.target, GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT);
    attach(job, {&winner_, nullptr}, &depth_);
    gl_.Enable(GL_DEPTH_TEST);
    gl_.DepthMask(GL_TRUE);
    gl_.DepthFunc(GL_LESS);  // points come in the order of their codes: ties stay with the lower one
    const float far = 1;
    const std::array<GLuint, 4> nobody{PointCode::none, 0, 0, 0};
    gl_.ClearBufferfv(GL_DEPTH, 0, &far);
    gl_.ClearBufferuiv(GL_COLOR, 0, nobody.data());
    draw(nearest_, job);
    read(GL_COLOR_ATTACHMENT0, job, GL_RED_INTEGER, GL_UNSIGNED_INT, out.winner.data());
    read(GL_COLOR_ATTACHMENT0, job, GL_DEPTH_COMPONENT, GL_FLOAT, out.depth.data());
    for (std::size_t i = 0; i < out.depth.size().pixels(); ++i) {
      float& depth = out.depth.data()[i];
      depth = out.winner.data()[i] == PointCode::none ? 0 : depth * scale;
    }
  }

  void coverage(const GlJob& job, ValidityMask& out) override {
    covered_.allocate(gl_, scratch_unit, job.target, GL_R8UI, GL_RED_INTEGER, GL_UNSIGNED_BYTE);
    attach(job, {&covered_, nullptr}, nullptr);
    const std::array<GLuint, 4> empty{};
    gl_.ClearBufferuiv(GL_COLOR, 0, empty.data());
    draw(coverage_, job);
    read(GL_COLOR_ATTACHMENT0, job, GL_RED_INTEGER, GL_UNSIGNED_BYTE, out.data());
  }

  void soft_splat(const GlJob& job, SoftSplat& out) override {
    colour_sum_.allocate(gl_, scratch_unit, job.target, GL_RGBA32F, GL_RGBA, GL_FLOAT);
    depth_sum_.allocate(gl_, scratch_unit, job.target, GL_R32F, GL_RED, GL_FLOAT);
    attach(job, {&colour_sum_, &depth_sum_}, nullptr);
    const std::array<float, 4> zero{};
    gl_.ClearBufferfv(GL_COLOR, 0, zero.data());
    gl_.ClearBufferfv(GL_COLOR, 1, zero.data());
    gl_.Enable(GL_BLEND);
    gl_.BlendEquationSeparate(GL_FUNC_ADD, GL_FUNC_ADD);
    gl_.BlendFuncSeparate(GL_ONE, GL_ONE, GL_ONE, GL_ONE);
    draw(soft_, job);
    sums_.resize(job.target);
    read(GL_COLOR_ATTACHMENT0, job, GL_RGBA, GL_FLOAT, sums_.data());
    read(GL_COLOR_ATTACHMENT1, job, GL_RED, GL_FLOAT, out.depth.data());
    const SoftMeans means(out);
    for (std::size_t i = 0; i < job.target.pixels(); ++i) {
      const auto& [red, green, blue, weight] = sums_.data()[i];
      means.set(i, weight, out.depth.data()[i], {red, green, blue});
    }
  }

 private:
  GlProgram program(std::string_view part, std::string_view vertex, std::string_view fragment) const {
    return {gl_,
            "#version 410 core\n",
            {{GL_VERTEX_SHADER, {"warp.glsl", part, "sprite.glsl", vertex}}, {GL_FRAGMENT_SHADER, {fragment}}}};
  }

  void attach(const GlJob& job, std::array<const GlRaster*, 2> colours, const GlRaster* depth) const {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    for (GLenum i = 0; i < 2; ++i)
      gl_.FramebufferTexture(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0 + i, colours[i] == nullptr ? 0 : colours[i]->id(), 0);
    gl_.FramebufferTexture(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, depth == nullptr ? 0 : depth->id(), 0);
    const std::array<GLenum, 2> buffers{GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    gl_.DrawBuffers(colours[1] == nullptr ? 1 : 2, buffers.data());
    if (gl_.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
      fail(ErrorCode::backend_missing, "the OpenGL driver cannot draw into our picture formats; use --renderer cpu");
    gl_.Viewport(0, 0, job.target.width, job.target.height);
  }

  void draw(const GlProgram& program, const GlJob& job) const {
    job.set_up(program, gl_);
    gl_.BindVertexArray(vertex_array_.id());
    gl_.DrawArrays(GL_POINTS, 0, static_cast<GLsizei>(job.source.pixels()));
  }

  void read(GLenum attachment, const GlJob& job, GLenum format, GLenum type, void* pixels) const {
    gl_.ReadBuffer(attachment);
    gl_.ReadPixels(0, 0, job.target.width, job.target.height, format, type, pixels);
  }

  const GlApi& gl_;
  GlProgram nearest_, coverage_, soft_;
  GlFramebuffer framebuffer_;
  GlVertexArray vertex_array_;
  GlRaster winner_, depth_, covered_, colour_sum_, depth_sum_;
  Image<std::array<float, 4>> sums_;
};

}  // namespace

std::unique_ptr<GlPath> make_sprite_path(const GlApi& gl) { return std::make_unique<SpritePath>(gl); }

}  // namespace uwv
