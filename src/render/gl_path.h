// SPDX-License-Identifier: Apache-2.0
// How the OpenGL renderer gets from points to pixels: the common frame around the two ways, compute shaders and point
// sprites.
#pragma once

#include <memory>

#include "render/gl_objects.h"
#include "uwv/render/rasterizer.h"

namespace uwv {

/// Texture units of the inputs, the same for every shader.
enum GlUnit : GLuint { depth_unit = 0, slope_unit = 1, colour_unit = 2, scratch_unit = 3, unit_count = 4 };

/// One drawing job. Inputs are already in the textures.
struct GlJob {
  WarpMap map;
  Size source, target;
  bool has_slopes = false;
  FootprintOptions footprint;
  bool has_colour = false;
  float sharpness = 0;
  float log_depth_max = 0;

  /// Makes the program current and sets every uniform it has.
  void set_up(const GlProgram& program, const GlApi& gl) const;
};

/// Draws jobs. Outputs have the target's size already.
class GlPath {
 public:
  virtual ~GlPath() = default;
  virtual const char* name() const = 0;
  /// Throws Error(backend_missing) when the driver's limits are too small for the job.
  virtual void check_limits(const GlJob& job) const = 0;
  virtual void zbuffer(const GlJob& job, ZBuffer& out) = 0;
  virtual void coverage(const GlJob& job, ValidityMask& out) = 0;
  virtual void soft_splat(const GlJob& job, SoftSplat& out) = 0;
};

std::unique_ptr<GlPath> make_compute_path(const GlApi& gl);
std::unique_ptr<GlPath> make_sprite_path(const GlApi& gl);

/// Turns the sums of one pixel into SoftSplat's means.
class SoftMeans {
 public:
  explicit SoftMeans(SoftSplat& out) : out_(out), has_colour_(!out.colour.empty()) {}
  void set(std::size_t pixel, float weight, float depth, const RgbF& colour) const {
    const bool valid = weight > 0;
    const float scale = valid ? 1 / weight : 0;
    out_.valid.data()[pixel] = valid ? 1 : 0;
    out_.depth.data()[pixel] = valid ? depth / weight : 0;
    if (has_colour_) out_.colour.data()[pixel] = {colour.r * scale, colour.g * scale, colour.b * scale};
  }

 private:
  SoftSplat& out_;
  bool has_colour_;
};

}  // namespace uwv
