// SPDX-License-Identifier: Apache-2.0
// The OpenGL renderer: the arithmetic of rasterizer.h in shaders. docs/headless-gl.md has the timings of both paths.
#pragma once

#include <memory>

#include "uwv/render/gl_context.h"
#include "uwv/render/rasterizer.h"

namespace uwv {

struct GlOptions {
  /// How points reach pixels; both give the same picture.
  enum class Path {
    automatic,  ///< Compute where the driver has it (OpenGL 4.3), else sprites.
    sprites,    ///< Point sprites drawn into a framebuffer with a 32-bit float depth test; OpenGL 4.1.
    compute,    ///< Compute shaders with atomic minima; needs OpenGL 4.3.
  };
  /// Compute was measured faster wherever we could measure (llvmpipe).
  Path path = Path::automatic;
};

/// Names as on the command line: "auto", "sprites", "compute"; parse throws Error(value_invalid) listing them.
std::string_view to_string(GlOptions::Path path);
GlOptions::Path parse_gl_path(std::string_view name);

/// The renderer on this context, which it owns. An adopted context's state is as before after every call.
/// Throws Error(backend_missing) when the driver lacks what the path needs or refuses a shader. Every call of the
/// renderer throws Error(backend_missing) when pictures are larger or footprints wider than the driver allows, and
/// Error(out_of_memory) when the driver runs out.
/// soft_splat: sums are taken in the order the driver likes, so results differ in the last digits from run to run.
std::unique_ptr<Rasterizer> make_gl_rasterizer(std::unique_ptr<GlContext> context, GlOptions options = {});

}  // namespace uwv
