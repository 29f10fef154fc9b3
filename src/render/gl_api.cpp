// SPDX-License-Identifier: Apache-2.0
#include "render/gl_api.h"

#include <string_view>

#include "uwv/core/error.h"

namespace uwv {
namespace {

// `precise`, which keeps the compiler from fusing multiplications and additions, arrived with 4.0, and separate
// viewports for depth with 4.1.
constexpr int oldest_version = 41;

bool has_extension(const GlApi& gl, std::string_view wanted) {
  const int count = gl.integer(GL_NUM_EXTENSIONS);
  for (int i = 0; i < count; ++i) {
    const auto* name = reinterpret_cast<const char*>(gl.GetStringi(GL_EXTENSIONS, static_cast<GLuint>(i)));
    if (name != nullptr && wanted == name) return true;
  }
  return false;
}

}  // namespace

GlApi load_gl_api(void* (*get_proc_address)(const char* name)) {
  GlApi gl;
  const char* missing = nullptr;
#define UWV_GL_LOOK_UP(type, name)                                \
  gl.name = reinterpret_cast<type>(get_proc_address("gl" #name)); \
  if (gl.name == nullptr) missing = "gl" #name;
  UWV_GL_COMPUTE(UWV_GL_LOOK_UP)
  const bool compute_functions = missing == nullptr;
  UWV_GL_CLIP_CONTROL(UWV_GL_LOOK_UP)
  missing = nullptr;
  UWV_GL_REQUIRED(UWV_GL_LOOK_UP)
#undef UWV_GL_LOOK_UP
  if (gl.GetString == nullptr || gl.GetIntegerv == nullptr || gl.GetString(GL_VERSION) == nullptr)
    fail(ErrorCode::backend_missing, "the context answers no OpenGL call; a working OpenGL driver is wanted");
  gl.version = 10 * gl.integer(GL_MAJOR_VERSION) + gl.integer(GL_MINOR_VERSION);
  if (gl.version < oldest_version)
    fail(ErrorCode::backend_missing, "the driver offers OpenGL {}.{}; at least 4.1 is wanted", gl.version / 10,
         gl.version % 10);
  if (missing != nullptr)
    fail(ErrorCode::backend_missing, "the driver claims OpenGL {}.{} but lacks {}; another driver is wanted",
         gl.version / 10, gl.version % 10, missing);
  gl.compute = gl.version >= 43 && compute_functions;
  if (gl.version < 45) gl.ClipControl = nullptr;  // look-ups may answer for functions the context does not have
  gl.float_atomics = gl.compute && has_extension(gl, "GL_NV_shader_atomic_float");
  return gl;
}

}  // namespace uwv
