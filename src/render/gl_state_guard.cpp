// SPDX-License-Identifier: Apache-2.0
#include "render/gl_state_guard.h"

namespace uwv {

GlStateGuard::GlStateGuard(const GlApi& gl) : gl_(gl) {
  // Somebody else's mistakes must not look like ours; a broken context may report errors without end.
  for (int i = 0; i < 16 && gl_.GetError() != GL_NO_ERROR; ++i) continue;
  save();
  set_neutral();
}

void GlStateGuard::save() {
  for (std::size_t i = 0; i < switches.size(); ++i) enabled_[i] = gl_.IsEnabled(switches[i]) == GL_TRUE;
  for (std::size_t i = 0; i < pixel_stores.size(); ++i) stores_[i] = gl_.integer(pixel_stores[i]);
  program_ = gl_.integer(GL_CURRENT_PROGRAM);
  vertex_array_ = gl_.integer(GL_VERTEX_ARRAY_BINDING);
  draw_framebuffer_ = gl_.integer(GL_DRAW_FRAMEBUFFER_BINDING);
  read_framebuffer_ = gl_.integer(GL_READ_FRAMEBUFFER_BINDING);
  pack_buffer_ = gl_.integer(GL_PIXEL_PACK_BUFFER_BINDING);
  unpack_buffer_ = gl_.integer(GL_PIXEL_UNPACK_BUFFER_BINDING);
  active_texture_ = gl_.integer(GL_ACTIVE_TEXTURE);
  for (GLuint unit = 0; unit < unit_count; ++unit) {
    gl_.ActiveTexture(GL_TEXTURE0 + unit);
    textures_[unit] = gl_.integer(GL_TEXTURE_BINDING_2D);
    samplers_[unit] = gl_.integer(GL_SAMPLER_BINDING);
  }
  gl_.GetIntegerv(GL_VIEWPORT, viewport_.data());
  depth_function_ = gl_.integer(GL_DEPTH_FUNC);
  gl_.GetBooleanv(GL_DEPTH_WRITEMASK, &depth_mask_);
  gl_.GetBooleanv(GL_COLOR_WRITEMASK, colour_mask_.data());
  gl_.GetDoublev(GL_DEPTH_RANGE, depth_range_.data());
  constexpr std::array<GLenum, 6> blend_names{GL_BLEND_EQUATION_RGB, GL_BLEND_EQUATION_ALPHA, GL_BLEND_SRC_RGB,
                                              GL_BLEND_DST_RGB,      GL_BLEND_SRC_ALPHA,      GL_BLEND_DST_ALPHA};
  for (std::size_t i = 0; i < blend_.size(); ++i) blend_[i] = gl_.integer(blend_names[i]);
  if (gl_.ClipControl != nullptr) {
    clip_origin_ = gl_.integer(GL_CLIP_ORIGIN);
    clip_depth_mode_ = gl_.integer(GL_CLIP_DEPTH_MODE);
  }
  if (!gl_.compute) return;
  storage_buffer_ = gl_.integer(GL_SHADER_STORAGE_BUFFER_BINDING);
  for (GLuint i = 0; i < storage_.size(); ++i) {
    gl_.GetIntegeri_v(GL_SHADER_STORAGE_BUFFER_BINDING, i, &storage_[i].buffer);
    gl_.GetInteger64i_v(GL_SHADER_STORAGE_BUFFER_START, i, &storage_[i].offset);
    gl_.GetInteger64i_v(GL_SHADER_STORAGE_BUFFER_SIZE, i, &storage_[i].size);
  }
}

void GlStateGuard::set_neutral() const {
  for (const GLenum name : switches) gl_.Disable(name);
  gl_.Enable(GL_PROGRAM_POINT_SIZE);
  for (const GLenum name : pixel_stores)
    gl_.PixelStorei(name, name == GL_PACK_ALIGNMENT || name == GL_UNPACK_ALIGNMENT ? 1 : 0);
  gl_.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  gl_.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  // A sampler object would override our textures' own filters and could make them incomplete.
  for (GLuint unit = 0; unit < unit_count; ++unit) gl_.BindSampler(unit, 0);
  gl_.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  gl_.DepthRange(0, 1);
  if (gl_.ClipControl != nullptr) gl_.ClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
}

GlStateGuard::~GlStateGuard() {
  for (std::size_t i = 0; i < switches.size(); ++i) enabled_[i] ? gl_.Enable(switches[i]) : gl_.Disable(switches[i]);
  for (std::size_t i = 0; i < pixel_stores.size(); ++i) gl_.PixelStorei(pixel_stores[i], stores_[i]);
  gl_.UseProgram(static_cast<GLuint>(program_));
  gl_.BindVertexArray(static_cast<GLuint>(vertex_array_));
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(draw_framebuffer_));
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, static_cast<GLuint>(read_framebuffer_));
  gl_.BindBuffer(GL_PIXEL_PACK_BUFFER, static_cast<GLuint>(pack_buffer_));
  gl_.BindBuffer(GL_PIXEL_UNPACK_BUFFER, static_cast<GLuint>(unpack_buffer_));
  for (GLuint unit = 0; unit < unit_count; ++unit) {
    gl_.ActiveTexture(GL_TEXTURE0 + unit);
    gl_.BindTexture(GL_TEXTURE_2D, static_cast<GLuint>(textures_[unit]));
    gl_.BindSampler(unit, static_cast<GLuint>(samplers_[unit]));
  }
  gl_.ActiveTexture(static_cast<GLenum>(active_texture_));
  gl_.Viewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
  gl_.DepthFunc(static_cast<GLenum>(depth_function_));
  gl_.DepthMask(depth_mask_);
  gl_.ColorMask(colour_mask_[0], colour_mask_[1], colour_mask_[2], colour_mask_[3]);
  gl_.DepthRange(depth_range_[0], depth_range_[1]);
  const auto blend = [this](std::size_t i) { return static_cast<GLenum>(blend_[i]); };
  gl_.BlendEquationSeparate(blend(0), blend(1));
  gl_.BlendFuncSeparate(blend(2), blend(3), blend(4), blend(5));
  if (gl_.ClipControl != nullptr)
    gl_.ClipControl(static_cast<GLenum>(clip_origin_), static_cast<GLenum>(clip_depth_mode_));
  if (!gl_.compute) return;
  for (GLuint i = 0; i < storage_.size(); ++i) {
    const auto& [buffer, offset, size] = storage_[i];
    if (buffer != 0 && size != 0)
      gl_.BindBufferRange(GL_SHADER_STORAGE_BUFFER, i, static_cast<GLuint>(buffer), static_cast<GLintptr>(offset),
                          static_cast<GLsizeiptr>(size));
    else
      gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, i, static_cast<GLuint>(buffer));
  }
  gl_.BindBuffer(GL_SHADER_STORAGE_BUFFER, static_cast<GLuint>(storage_buffer_));
}

}  // namespace uwv
