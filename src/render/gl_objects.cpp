// SPDX-License-Identifier: Apache-2.0
#include "render/gl_objects.h"

#include <string>
#include <vector>

#include "render/gl_shaders.h"
#include "uwv/core/error.h"

namespace uwv {
namespace {

std::string one_line(std::string text) {
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  return text;
}

GLuint compile(const GlApi& gl, std::string_view head, const GlProgram::Stage& stage) {
  std::string text(head);
  for (const std::string_view file : stage.files) text += fmt::format("#line 1\n{}\n", shader_text(file));
  const GLuint shader = gl.CreateShader(stage.kind);
  const char* source = text.c_str();
  gl.ShaderSource(shader, 1, &source, nullptr);
  gl.CompileShader(shader);
  GLint compiled = GL_FALSE;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  if (compiled == GL_TRUE) return shader;
  std::string log(4096, '\0');
  GLsizei length = 0;
  gl.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), &length, log.data());
  log.resize(static_cast<std::size_t>(length));
  gl.DeleteShader(shader);
  fail(ErrorCode::backend_missing, "the OpenGL driver refuses our shader {} ({}); use --renderer cpu",
       *(stage.files.end() - 1), one_line(log));
}

}  // namespace

GlProgram::GlProgram(const GlApi& gl, std::string_view head, std::initializer_list<Stage> stages)
    : gl_(&gl), id_(gl.CreateProgram()) {
  for (const Stage& stage : stages) {
    const GLuint shader = compile(gl, head, stage);
    gl.AttachShader(id_, shader);
    gl.DeleteShader(shader);  // lives on as long as the program does
  }
  gl.LinkProgram(id_);
  GLint linked = GL_FALSE;
  gl.GetProgramiv(id_, GL_LINK_STATUS, &linked);
  if (linked == GL_TRUE) return;
  std::string log(4096, '\0');
  GLsizei length = 0;
  gl.GetProgramInfoLog(id_, static_cast<GLsizei>(log.size()), &length, log.data());
  log.resize(static_cast<std::size_t>(length));
  gl.DeleteProgram(id_);
  fail(ErrorCode::backend_missing, "the OpenGL driver cannot link our shaders ({}); use --renderer cpu", one_line(log));
}

GlProgram::~GlProgram() {
  if (id_ != 0) gl_->DeleteProgram(id_);
}

void GlRaster::allocate(const GlApi& gl, GLuint unit, Size size, GLenum internal, GLenum format, GLenum type) {
  if (texture_.id() == 0) {
    GLuint id = 0;
    gl.GenTextures(1, &id);
    texture_ = GlTexture(gl, id);
  }
  bind(gl, unit);
  if (size == size_) return;
  size_ = {};  // should the driver refuse
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  gl.TexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(internal), size.width, size.height, 0, format, type, nullptr);
  check_gl(gl, fmt::format("making a {}x{} texture", size.width, size.height));
  size_ = size;
  format_ = format;
  type_ = type;
}

void GlRaster::upload(const GlApi& gl, const void* pixels) const {
  gl.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, size_.width, size_.height, format_, type_, pixels);
}

void GlRaster::bind(const GlApi& gl, GLuint unit) const {
  gl.ActiveTexture(GL_TEXTURE0 + unit);
  gl.BindTexture(GL_TEXTURE_2D, texture_.id());
}

void GlWords::fill(const GlApi& gl, GLuint binding, std::size_t count, std::uint32_t value) {
  if (buffer_.id() == 0) {
    GLuint id = 0;
    gl.GenBuffers(1, &id);
    buffer_ = GlBuffer(gl, id);
  }
  gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer_.id());
  if (count > capacity_) {
    capacity_ = 0;  // should the driver refuse
    gl.BufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(4 * count), nullptr, GL_DYNAMIC_READ);
    check_gl(gl, fmt::format("making a buffer of {} bytes", 4 * count));
    capacity_ = count;
  }
  gl.ClearBufferSubData(GL_SHADER_STORAGE_BUFFER, GL_R32UI, 0, static_cast<GLsizeiptr>(4 * count), GL_RED_INTEGER,
                        GL_UNSIGNED_INT, &value);
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer_.id());
}

GlMapping::GlMapping(const GlApi& gl, const GlWords& words, std::size_t count) : gl_(gl), buffer_(words.id()) {
  gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer_);
  address_ = gl.MapBufferRange(GL_SHADER_STORAGE_BUFFER, 0, static_cast<GLsizeiptr>(4 * count), GL_MAP_READ_BIT);
  if (address_ != nullptr) return;
  check_gl(gl, "reading a result back");
  fail(ErrorCode::backend_missing, "the OpenGL driver does not let us read {} bytes back; use --renderer cpu",
       4 * count);
}

GlMapping::~GlMapping() {
  gl_.BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer_);
  gl_.UnmapBuffer(GL_SHADER_STORAGE_BUFFER);
}

GlFramebuffer make_framebuffer(const GlApi& gl) {
  GLuint id = 0;
  gl.GenFramebuffers(1, &id);
  return {gl, id};
}

GlVertexArray make_vertex_array(const GlApi& gl) {
  GLuint id = 0;
  gl.GenVertexArrays(1, &id);
  return {gl, id};
}

void check_gl(const GlApi& gl, std::string_view step) {
  const GLenum error = gl.GetError();
  if (error == GL_NO_ERROR) return;
  // A broken context may report errors without end.
  for (int i = 0; i < 16 && gl.GetError() != GL_NO_ERROR; ++i) continue;
  if (error == GL_OUT_OF_MEMORY)
    fail(ErrorCode::out_of_memory, "OpenGL ran out of memory while {}; use a smaller picture or --renderer cpu", step);
  fail(ErrorCode::backend_missing, "OpenGL reported error 0x{:x} while {}; use --renderer cpu", error, step);
}

}  // namespace uwv
