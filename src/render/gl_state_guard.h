// SPDX-License-Identifier: Apache-2.0
// Leaves an OpenGL context as it was found, so that a window may share its context with the renderer.
#pragma once

#include <array>

#include "render/gl_api.h"
#include "render/gl_path.h"

namespace uwv {

/// Saves what our drawing changes, sets the state our drawing relies on, and restores on destruction.
class GlStateGuard {
 public:
  explicit GlStateGuard(const GlApi& gl);
  ~GlStateGuard();
  GlStateGuard(const GlStateGuard&) = delete;
  GlStateGuard& operator=(const GlStateGuard&) = delete;

 private:
  void save();
  void set_neutral() const;

  // Everything that would drop, mix or redirect our pixels; all off but the program's own point size.
  static constexpr std::array<GLenum, 20> switches{
      GL_PROGRAM_POINT_SIZE, GL_DEPTH_TEST,       GL_BLEND,
      GL_SCISSOR_TEST,       GL_STENCIL_TEST,     GL_COLOR_LOGIC_OP,
      GL_RASTERIZER_DISCARD, GL_FRAMEBUFFER_SRGB, GL_DEPTH_CLAMP,
      GL_SAMPLE_MASK,        GL_SAMPLE_COVERAGE,  GL_SAMPLE_ALPHA_TO_COVERAGE,
      GL_CLIP_DISTANCE0,     GL_CLIP_DISTANCE1,   GL_CLIP_DISTANCE2,
      GL_CLIP_DISTANCE3,     GL_CLIP_DISTANCE4,   GL_CLIP_DISTANCE5,
      GL_CLIP_DISTANCE6,     GL_CLIP_DISTANCE7};
  static constexpr std::array<GLenum, 10> pixel_stores{
      GL_UNPACK_SWAP_BYTES, GL_UNPACK_ROW_LENGTH, GL_UNPACK_SKIP_ROWS, GL_UNPACK_SKIP_PIXELS, GL_UNPACK_ALIGNMENT,
      GL_PACK_SWAP_BYTES,   GL_PACK_ROW_LENGTH,   GL_PACK_SKIP_ROWS,   GL_PACK_SKIP_PIXELS,   GL_PACK_ALIGNMENT};

  struct StorageBinding {
    GLint buffer = 0;
    GLint64 offset = 0, size = 0;
  };

  const GlApi& gl_;
  std::array<bool, switches.size()> enabled_{};
  std::array<GLint, pixel_stores.size()> stores_{};
  GLint program_ = 0, vertex_array_ = 0, draw_framebuffer_ = 0, read_framebuffer_ = 0, active_texture_ = 0;
  GLint pack_buffer_ = 0, unpack_buffer_ = 0, storage_buffer_ = 0, depth_function_ = 0, clip_origin_ = 0,
        clip_depth_mode_ = 0;
  std::array<GLint, unit_count> textures_{}, samplers_{};
  std::array<GLint, 4> viewport_{};
  std::array<GLint, 6> blend_{};  // equations of colour and alpha, then their four factors
  std::array<GLboolean, 4> colour_mask_{};
  GLboolean depth_mask_ = GL_TRUE;
  std::array<GLdouble, 2> depth_range_{};
  std::array<StorageBinding, 5> storage_{};
};

}  // namespace uwv
