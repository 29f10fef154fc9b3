// SPDX-License-Identifier: Apache-2.0
// OpenGL objects that delete themselves, and the few ways we make them. Everything here needs a current context.
#pragma once

#include <initializer_list>
#include <string_view>
#include <utility>

#include "render/gl_api.h"
#include "uwv/core/image.h"

namespace uwv {

/// Owns one object name; `Delete` is the GlApi member that deletes an array of them.
template <auto Delete>
class GlHandle {
 public:
  GlHandle() = default;
  GlHandle(const GlApi& gl, GLuint id) : gl_(&gl), id_(id) {}
  GlHandle(GlHandle&& other) noexcept : gl_(other.gl_), id_(std::exchange(other.id_, 0)) {}
  GlHandle& operator=(GlHandle&& other) noexcept {
    std::swap(gl_, other.gl_);
    std::swap(id_, other.id_);
    return *this;
  }
  ~GlHandle() {
    if (id_ != 0) (gl_->*Delete)(1, &id_);
  }
  GLuint id() const { return id_; }

 private:
  const GlApi* gl_ = nullptr;
  GLuint id_ = 0;
};
using GlTexture = GlHandle<&GlApi::DeleteTextures>;
using GlBuffer = GlHandle<&GlApi::DeleteBuffers>;
using GlFramebuffer = GlHandle<&GlApi::DeleteFramebuffers>;
using GlVertexArray = GlHandle<&GlApi::DeleteVertexArrays>;

/// A linked program. Uniforms it does not use are silently ignored, as OpenGL does.
class GlProgram {
 public:
  GlProgram() = default;
  /// One stage: its kind and the files of shaders/ that make it up, in order.
  struct Stage {
    GLenum kind;
    std::initializer_list<std::string_view> files;
  };
  /// `head` goes before every stage: the version line, extensions, defines. Throws Error(backend_missing) with the
  /// driver's words when it does not compile.
  GlProgram(const GlApi& gl, std::string_view head, std::initializer_list<Stage> stages);
  GlProgram(GlProgram&& other) noexcept : gl_(other.gl_), id_(std::exchange(other.id_, 0)) {}
  GlProgram& operator=(GlProgram&& other) noexcept {
    std::swap(gl_, other.gl_);
    std::swap(id_, other.id_);
    return *this;
  }
  ~GlProgram();

  void use() const { gl_->UseProgram(id_); }
  GLint location(const char* uniform) const { return gl_->GetUniformLocation(id_, uniform); }

 private:
  const GlApi* gl_ = nullptr;
  GLuint id_ = 0;
};

/// A texture that keeps its storage between uses and is only fetched texel by texel. Made on texture unit `unit`, which
/// it stays bound to.
class GlRaster {
 public:
  /// Makes storage of `size` unless it is there already. `internal` is a sized format.
  void allocate(const GlApi& gl, GLuint unit, Size size, GLenum internal, GLenum format, GLenum type);
  /// Replaces all texels; `allocate` came right before.
  void upload(const GlApi& gl, const void* pixels) const;
  void bind(const GlApi& gl, GLuint unit) const;
  GLuint id() const { return texture_.id(); }
  Size size() const { return size_; }

 private:
  GlTexture texture_;
  Size size_;
  GLenum format_ = 0, type_ = 0;
};

/// A storage buffer of 32-bit words that keeps its memory between uses.
class GlWords {
 public:
  /// Sets the first `count` words to `value`, making memory for them when needed, and binds the buffer to storage
  /// binding `binding`.
  void fill(const GlApi& gl, GLuint binding, std::size_t count, std::uint32_t value);
  GLuint id() const { return buffer_.id(); }

 private:
  GlBuffer buffer_;
  std::size_t capacity_ = 0;
};

/// A buffer's words in our memory, for reading, while this lives.
class GlMapping {
 public:
  GlMapping(const GlApi& gl, const GlWords& words, std::size_t count);
  ~GlMapping();
  GlMapping(const GlMapping&) = delete;
  GlMapping& operator=(const GlMapping&) = delete;
  const std::uint32_t* words() const { return static_cast<const std::uint32_t*>(address_); }
  const float* floats() const { return static_cast<const float*>(address_); }

 private:
  const GlApi& gl_;
  GLuint buffer_;
  const void* address_;
};

GlFramebuffer make_framebuffer(const GlApi& gl);
GlVertexArray make_vertex_array(const GlApi& gl);

/// Throws Error(backend_missing) naming `step` when OpenGL has recorded an error, out_of_memory when it ran out.
void check_gl(const GlApi& gl, std::string_view step);

}  // namespace uwv
