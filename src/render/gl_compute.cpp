// SPDX-License-Identifier: Apache-2.0
// The z-buffer as two compute passes of atomic minima, coverage and the soft splat as one pass each.
#include <algorithm>
#include <bit>

#include "render/gl_path.h"

namespace uwv {
namespace {

constexpr int group_width = 64;  // local_size_x of the shaders
constexpr std::uint32_t nothing = 0xFFFFFFFFU;

class ComputePath final : public GlPath {
 public:
  explicit ComputePath(const GlApi& gl)
      : gl_(gl),
        nearest_depth_(program("nearest_depth.comp", "footprint.glsl")),
        nearest_code_(program("nearest_code.comp", "footprint.glsl")),
        coverage_(program("coverage.comp", "footprint.glsl")) {
    // Adding floats by compare-and-swap was measured five times slower than NVIDIA's atomics, and slower than blending.
    if (gl.float_atomics)
      soft_splat_ = program("soft_splat.comp", "soft.glsl");
    else
      blending_ = make_sprite_path(gl);
  }

  const char* name() const override { return "compute"; }

  void check_limits(const GlJob& job) const override {
    const std::size_t bytes = 4 * job.target.pixels();
    const auto largest = static_cast<std::size_t>(gl_.integer(GL_MAX_SHADER_STORAGE_BLOCK_SIZE));
    if (bytes > largest)
      fail(ErrorCode::backend_missing,
           "a {}x{} picture needs storage blocks of {} bytes, this OpenGL driver allows {}; use --renderer cpu",
           job.target.width, job.target.height, bytes, largest);
  }

  void zbuffer(const GlJob& job, ZBuffer& out) override {
    const std::size_t pixels = job.target.pixels();
    words_[0].fill(gl_, 0, pixels, nothing);
    words_[1].fill(gl_, 1, pixels, PointCode::none);
    run(nearest_depth_, job);
    gl_.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    run(nearest_code_, job);
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    const GlMapping winners(gl_, words_[1], pixels);
    std::copy_n(winners.words(), pixels, out.winner.data());
    const GlMapping bits(gl_, words_[0], pixels);
    std::transform(bits.words(), bits.words() + pixels, out.depth.data(),
                   [](std::uint32_t word) { return word == nothing ? 0.0F : std::bit_cast<float>(word); });
  }

  void coverage(const GlJob& job, ValidityMask& out) override {
    const std::size_t pixels = job.target.pixels();
    words_[0].fill(gl_, 0, pixels, 0);
    run(coverage_, job);
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    const GlMapping covered(gl_, words_[0], pixels);
    std::transform(covered.words(), covered.words() + pixels, out.data(),
                   [](std::uint32_t word) { return static_cast<std::uint8_t>(word); });
  }

  void soft_splat(const GlJob& job, SoftSplat& out) override {
    if (blending_ != nullptr) {
      blending_->check_limits(job);
      blending_->soft_splat(job, out);
      return;
    }
    const std::size_t pixels = job.target.pixels();
    // Planes that will not be written still have to exist.
    for (GLuint plane = 0; plane < 5; ++plane)
      words_[plane].fill(gl_, plane, plane < 2 || job.has_colour ? pixels : 1, 0);
    run(soft_splat_, job);
    gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    const std::size_t coloured = job.has_colour ? pixels : 1;
    const GlMapping weight(gl_, words_[0], pixels), depth(gl_, words_[1], pixels);
    const GlMapping red(gl_, words_[2], coloured), green(gl_, words_[3], coloured), blue(gl_, words_[4], coloured);
    const SoftMeans means(out);
    for (std::size_t i = 0; i < pixels; ++i) {
      const std::size_t c = job.has_colour ? i : 0;
      means.set(i, weight.floats()[i], depth.floats()[i], {red.floats()[c], green.floats()[c], blue.floats()[c]});
    }
  }

 private:
  GlProgram program(std::string_view shader, std::string_view part) const {
    const char* head = gl_.float_atomics ? "#version 430 core\n#extension GL_NV_shader_atomic_float : require\n"
                                         : "#version 430 core\n";
    return {gl_, head, {{GL_COMPUTE_SHADER, {"warp.glsl", part, shader}}}};
  }

  void run(const GlProgram& program, const GlJob& job) const {
    job.set_up(program, gl_);
    gl_.DispatchCompute(static_cast<GLuint>((job.source.width + group_width - 1) / group_width),
                        static_cast<GLuint>(job.source.height), 1);
  }

  const GlApi& gl_;
  GlProgram nearest_depth_, nearest_code_, coverage_, soft_splat_;
  std::unique_ptr<GlPath> blending_;  // draws soft splats where compute shaders cannot add floats
  GlWords words_[5];
};

}  // namespace

std::unique_ptr<GlPath> make_compute_path(const GlApi& gl) {
  if (!gl.compute)
    fail(ErrorCode::backend_missing,
         "this context has OpenGL {}.{} without compute shaders (4.3); use the sprites path", gl.version / 10,
         gl.version % 10);
  return std::make_unique<ComputePath>(gl);
}

}  // namespace uwv
