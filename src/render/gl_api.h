// SPDX-License-Identifier: Apache-2.0
// The OpenGL functions we call, looked up per context: EGL, OSMesa and window toolkits each have their own look-up, and
// a loader that knows only some of them (libepoxy finds nothing in an OSMesa context) cannot serve all.
#pragma once

#include <GL/glcorearb.h>

// Present in every context we accept (OpenGL 4.1).
#define UWV_GL_REQUIRED(X)                                   \
  X(PFNGLACTIVETEXTUREPROC, ActiveTexture)                   \
  X(PFNGLATTACHSHADERPROC, AttachShader)                     \
  X(PFNGLBINDBUFFERPROC, BindBuffer)                         \
  X(PFNGLBINDBUFFERBASEPROC, BindBufferBase)                 \
  X(PFNGLBINDBUFFERRANGEPROC, BindBufferRange)               \
  X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer)               \
  X(PFNGLBINDSAMPLERPROC, BindSampler)                       \
  X(PFNGLBINDTEXTUREPROC, BindTexture)                       \
  X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)               \
  X(PFNGLBLENDEQUATIONSEPARATEPROC, BlendEquationSeparate)   \
  X(PFNGLBLENDFUNCSEPARATEPROC, BlendFuncSeparate)           \
  X(PFNGLBUFFERDATAPROC, BufferData)                         \
  X(PFNGLCHECKFRAMEBUFFERSTATUSPROC, CheckFramebufferStatus) \
  X(PFNGLCLEARBUFFERFVPROC, ClearBufferfv)                   \
  X(PFNGLCLEARBUFFERUIVPROC, ClearBufferuiv)                 \
  X(PFNGLCOLORMASKPROC, ColorMask)                           \
  X(PFNGLCOMPILESHADERPROC, CompileShader)                   \
  X(PFNGLCREATEPROGRAMPROC, CreateProgram)                   \
  X(PFNGLCREATESHADERPROC, CreateShader)                     \
  X(PFNGLDELETEBUFFERSPROC, DeleteBuffers)                   \
  X(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers)         \
  X(PFNGLDELETEPROGRAMPROC, DeleteProgram)                   \
  X(PFNGLDELETESHADERPROC, DeleteShader)                     \
  X(PFNGLDELETETEXTURESPROC, DeleteTextures)                 \
  X(PFNGLDELETEVERTEXARRAYSPROC, DeleteVertexArrays)         \
  X(PFNGLDEPTHFUNCPROC, DepthFunc)                           \
  X(PFNGLDEPTHMASKPROC, DepthMask)                           \
  X(PFNGLDEPTHRANGEPROC, DepthRange)                         \
  X(PFNGLDISABLEPROC, Disable)                               \
  X(PFNGLDRAWARRAYSPROC, DrawArrays)                         \
  X(PFNGLDRAWBUFFERSPROC, DrawBuffers)                       \
  X(PFNGLENABLEPROC, Enable)                                 \
  X(PFNGLFRAMEBUFFERTEXTUREPROC, FramebufferTexture)         \
  X(PFNGLGENBUFFERSPROC, GenBuffers)                         \
  X(PFNGLGENFRAMEBUFFERSPROC, GenFramebuffers)               \
  X(PFNGLGENTEXTURESPROC, GenTextures)                       \
  X(PFNGLGENVERTEXARRAYSPROC, GenVertexArrays)               \
  X(PFNGLGETBOOLEANVPROC, GetBooleanv)                       \
  X(PFNGLGETDOUBLEVPROC, GetDoublev)                         \
  X(PFNGLGETERRORPROC, GetError)                             \
  X(PFNGLGETFLOATVPROC, GetFloatv)                           \
  X(PFNGLGETINTEGER64I_VPROC, GetInteger64i_v)               \
  X(PFNGLGETINTEGERI_VPROC, GetIntegeri_v)                   \
  X(PFNGLGETINTEGERVPROC, GetIntegerv)                       \
  X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)           \
  X(PFNGLGETPROGRAMIVPROC, GetProgramiv)                     \
  X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)             \
  X(PFNGLGETSHADERIVPROC, GetShaderiv)                       \
  X(PFNGLGETSTRINGPROC, GetString)                           \
  X(PFNGLGETSTRINGIPROC, GetStringi)                         \
  X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation)         \
  X(PFNGLISENABLEDPROC, IsEnabled)                           \
  X(PFNGLLINKPROGRAMPROC, LinkProgram)                       \
  X(PFNGLMAPBUFFERRANGEPROC, MapBufferRange)                 \
  X(PFNGLPIXELSTOREIPROC, PixelStorei)                       \
  X(PFNGLREADBUFFERPROC, ReadBuffer)                         \
  X(PFNGLREADPIXELSPROC, ReadPixels)                         \
  X(PFNGLSHADERSOURCEPROC, ShaderSource)                     \
  X(PFNGLTEXIMAGE2DPROC, TexImage2D)                         \
  X(PFNGLTEXPARAMETERIPROC, TexParameteri)                   \
  X(PFNGLTEXSUBIMAGE2DPROC, TexSubImage2D)                   \
  X(PFNGLUNIFORM1FPROC, Uniform1f)                           \
  X(PFNGLUNIFORM1FVPROC, Uniform1fv)                         \
  X(PFNGLUNIFORM1IPROC, Uniform1i)                           \
  X(PFNGLUNIFORM2IPROC, Uniform2i)                           \
  X(PFNGLUNMAPBUFFERPROC, UnmapBuffer)                       \
  X(PFNGLUSEPROGRAMPROC, UseProgram)                         \
  X(PFNGLVIEWPORTPROC, Viewport)

// Compute shaders (OpenGL 4.3); null in older contexts.
#define UWV_GL_COMPUTE(X)                            \
  X(PFNGLCLEARBUFFERSUBDATAPROC, ClearBufferSubData) \
  X(PFNGLDISPATCHCOMPUTEPROC, DispatchCompute)       \
  X(PFNGLMEMORYBARRIERPROC, MemoryBarrier)

// Where a window may have turned the picture upside down (OpenGL 4.5); null in older contexts.
#define UWV_GL_CLIP_CONTROL(X) X(PFNGLCLIPCONTROLPROC, ClipControl)

namespace uwv {

struct GlApi {
#define UWV_GL_MEMBER(type, name) type name = nullptr;
  UWV_GL_REQUIRED(UWV_GL_MEMBER)
  UWV_GL_COMPUTE(UWV_GL_MEMBER)
  UWV_GL_CLIP_CONTROL(UWV_GL_MEMBER)
#undef UWV_GL_MEMBER

  int version = 0;             ///< 10 * major + minor.
  bool compute = false;        ///< Compute shaders and storage buffers can be used.
  bool float_atomics = false;  ///< GL_NV_shader_atomic_float.

  int integer(GLenum name) const {
    GLint value = 0;
    GetIntegerv(name, &value);
    return value;
  }
};

/// Looks everything up in the current context. Throws Error(backend_missing) when it is older than 4.1 or lacks a
/// function.
GlApi load_gl_api(void* (*get_proc_address)(const char* name));

}  // namespace uwv
