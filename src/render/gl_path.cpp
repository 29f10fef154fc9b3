// SPDX-License-Identifier: Apache-2.0
#include "render/gl_path.h"

#include <array>

namespace uwv {

void GlJob::set_up(const GlProgram& program, const GlApi& gl) const {
  program.use();
  std::array<float, 9> a{};
  for (std::size_t i = 0; i < 9; ++i) a[i] = map.a[i / 3][i % 3];
  gl.Uniform1fv(program.location("warp_a"), 9, a.data());
  gl.Uniform1fv(program.location("warp_b"), 3, map.b.data());
  gl.Uniform2i(program.location("source_size"), source.width, source.height);
  gl.Uniform2i(program.location("target_size"), target.width, target.height);
  gl.Uniform1i(program.location("depth_map"), depth_unit);
  gl.Uniform1i(program.location("slope_map"), slope_unit);
  gl.Uniform1i(program.location("colour_map"), colour_unit);
  gl.Uniform1i(program.location("has_slopes"), has_slopes ? 1 : 0);
  gl.Uniform1i(program.location("has_colour"), has_colour ? 1 : 0);
  gl.Uniform1f(program.location("point_size"), footprint.point_size);
  gl.Uniform1f(program.location("min_footprint"), footprint.min_footprint);
  gl.Uniform1f(program.location("max_footprint"), footprint.max_footprint);
  gl.Uniform1f(program.location("sharpness"), sharpness);
  gl.Uniform1f(program.location("log_depth_max"), log_depth_max);
}

}  // namespace uwv
