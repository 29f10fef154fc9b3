// SPDX-License-Identifier: Apache-2.0
#include <GL/glcorearb.h>

#include <array>

#include "render/gl_backends.h"
#include "render/gl_library.h"
#include "uwv/core/error.h"

namespace uwv {
namespace {

// The few names of OSMesa's interface (its header wants the classic gl.h, which clashes with glcorearb.h).
constexpr int osmesa_format = 0x22;
constexpr int osmesa_profile = 0x33;
constexpr int osmesa_core_profile = 0x34;
constexpr int osmesa_major_version = 0x36;
constexpr int osmesa_minor_version = 0x37;

struct OsMesa {
  GlLibrary library{"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"};
  void* (*create)(const int* attributes, void* shared) = nullptr;
  void (*destroy)(void* context) = nullptr;
  unsigned char (*make_current)(void* context, void* buffer, GLenum type, GLsizei width, GLsizei height) = nullptr;
  void* (*get_proc_address)(const char* name) = nullptr;

  OsMesa() {
    if (library.handle == nullptr)
      fail(ErrorCode::backend_missing, "libOSMesa cannot be opened ({}); install libosmesa6", library.reason);
    if (!library.find(create, "OSMesaCreateContextAttribs") || !library.find(destroy, "OSMesaDestroyContext") ||
        !library.find(make_current, "OSMesaMakeCurrent") || !library.find(get_proc_address, "OSMesaGetProcAddress"))
      fail(ErrorCode::backend_missing, "libOSMesa is too old to choose an OpenGL version; Mesa 12 or newer is wanted");
  }
};

class OsMesaContext final : public GlContext {
 public:
  OsMesaContext() : GlContext("osmesa") {
    const std::array<int, 9> attributes{osmesa_format,
                                        GL_RGBA,
                                        osmesa_profile,
                                        osmesa_core_profile,
                                        osmesa_major_version,
                                        4,
                                        osmesa_minor_version,
                                        1,
                                        0};
    context_ = mesa_.create(attributes.data(), nullptr);
    if (context_ == nullptr) fail(ErrorCode::backend_missing, "OSMesa offers no OpenGL 4.1 core context");
    try {
      const GlCurrent current(*this);
      load(mesa_.get_proc_address);
    } catch (...) {
      mesa_.destroy(context_);
      throw;
    }
  }
  ~OsMesaContext() override { mesa_.destroy(context_); }

 private:
  void make_current() override {
    if (mesa_.make_current(context_, picture_.data(), GL_UNSIGNED_BYTE, 1, 1) == 0)
      fail(ErrorCode::backend_missing, "OSMesa cannot make its context current");
  }
  void release() noexcept override { mesa_.make_current(nullptr, nullptr, 0, 0, 0); }

  OsMesa mesa_;
  void* context_ = nullptr;
  std::array<unsigned char, 4> picture_{};  // OSMesa insists on a window picture; we only draw into our own.
};

}  // namespace

GlCandidate osmesa_candidate() {
  return {"osmesa", [] { return std::make_unique<OsMesaContext>(); }};
}

}  // namespace uwv
