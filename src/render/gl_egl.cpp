// SPDX-License-Identifier: Apache-2.0
#define EGL_NO_X11
#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <array>
#include <string_view>

#include "render/gl_backends.h"
#include "render/gl_library.h"
#include "uwv/core/error.h"

namespace uwv {
namespace {

constexpr EGLint max_devices = 16;

struct Egl {
  GlLibrary library{"libEGL.so.1", "libEGL.so"};
  PFNEGLGETPROCADDRESSPROC get_proc_address = nullptr;
  PFNEGLQUERYSTRINGPROC query_string = nullptr;
  PFNEGLINITIALIZEPROC initialize = nullptr;
  PFNEGLBINDAPIPROC bind_api = nullptr;
  PFNEGLQUERYAPIPROC query_api = nullptr;
  PFNEGLCREATECONTEXTPROC create_context = nullptr;
  PFNEGLDESTROYCONTEXTPROC destroy_context = nullptr;
  PFNEGLMAKECURRENTPROC make_current = nullptr;
  PFNEGLGETCURRENTCONTEXTPROC current_context = nullptr;
  PFNEGLGETCURRENTDISPLAYPROC current_display = nullptr;
  PFNEGLGETCURRENTSURFACEPROC current_surface = nullptr;
  PFNEGLGETERRORPROC get_error = nullptr;
  PFNEGLGETPLATFORMDISPLAYEXTPROC get_platform_display = nullptr;
  PFNEGLQUERYDEVICESEXTPROC query_devices = nullptr;

  Egl() {
    if (library.handle == nullptr)
      fail(ErrorCode::backend_missing, "libEGL cannot be opened ({}); install libegl1", library.reason);
    const bool complete =
        library.find(get_proc_address, "eglGetProcAddress") && library.find(query_string, "eglQueryString") &&
        library.find(initialize, "eglInitialize") && library.find(bind_api, "eglBindAPI") &&
        library.find(query_api, "eglQueryAPI") && library.find(create_context, "eglCreateContext") &&
        library.find(destroy_context, "eglDestroyContext") && library.find(make_current, "eglMakeCurrent") &&
        library.find(current_context, "eglGetCurrentContext") &&
        library.find(current_display, "eglGetCurrentDisplay") &&
        library.find(current_surface, "eglGetCurrentSurface") && library.find(get_error, "eglGetError");
    if (!complete) fail(ErrorCode::backend_missing, "libEGL lacks basic functions; EGL 1.4 or newer is wanted");
    get_platform_display =
        reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(get_proc_address("eglGetPlatformDisplayEXT"));
    query_devices = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(get_proc_address("eglQueryDevicesEXT"));
  }

  bool client_has(std::string_view extension) const { return lists(EGL_NO_DISPLAY, extension); }
  bool lists(EGLDisplay display, std::string_view extension) const {
    const char* all = query_string(display, EGL_EXTENSIONS);
    if (all == nullptr) return false;
    const std::string padded = fmt::format(" {} ", all);
    return padded.find(fmt::format(" {} ", extension)) != std::string::npos;
  }
  std::array<EGLDeviceEXT, max_devices> devices(EGLint& count) const {
    std::array<EGLDeviceEXT, max_devices> found{};
    count = 0;
    if (query_devices == nullptr || query_devices(max_devices, found.data(), &count) == EGL_FALSE) count = 0;
    return found;
  }
};

class EglContext final : public GlContext {
 public:
  EglContext(const std::string& name, EGLenum platform, EGLint device) : GlContext(name) {
    open_display(platform, device);
    EGLint major = 0, minor = 0;
    // Never terminated: a display is one per process, and somebody else may be using it.
    if (egl_.initialize(display_, &major, &minor) == EGL_FALSE)
      fail(ErrorCode::backend_missing, "eglInitialize failed with error 0x{:x} (is the driver's device file readable?)",
           egl_.get_error());
    for (const char* needed : {"EGL_KHR_create_context", "EGL_KHR_surfaceless_context", "EGL_KHR_no_config_context"})
      if (!egl_.lists(display_, needed))
        fail(ErrorCode::backend_missing, "the EGL driver lacks {}, without which nothing can be drawn off screen",
             needed);
    create();
    try {
      const GlCurrent current(*this);
      load(gl_proc_address());
    } catch (...) {
      egl_.destroy_context(display_, context_);
      throw;
    }
  }
  ~EglContext() override { egl_.destroy_context(display_, context_); }

 private:
  void open_display(EGLenum platform, EGLint device) {
    if (egl_.get_platform_display == nullptr)
      fail(ErrorCode::backend_missing, "libEGL lacks EGL_EXT_platform_base; a newer one is wanted");
    void* native = EGL_DEFAULT_DISPLAY;
    if (platform == EGL_PLATFORM_DEVICE_EXT) {
      EGLint count = 0;
      const auto devices = egl_.devices(count);
      if (device >= count)
        fail(ErrorCode::backend_missing, "EGL lists {} devices; device {} does not exist", count, device);
      native = devices[static_cast<std::size_t>(device)];
    }
    display_ = egl_.get_platform_display(platform, native, nullptr);
    if (display_ == EGL_NO_DISPLAY)
      fail(ErrorCode::backend_missing, "EGL offers no such display (error 0x{:x})", egl_.get_error());
  }

  void create() {
    const EGLenum api = egl_.query_api();
    if (egl_.bind_api(EGL_OPENGL_API) == EGL_FALSE)
      fail(ErrorCode::backend_missing, "the EGL driver offers OpenGL ES only; desktop OpenGL is wanted");
    const std::array<EGLint, 7> attributes{
        EGL_CONTEXT_MAJOR_VERSION,           4,       EGL_CONTEXT_MINOR_VERSION, 1, EGL_CONTEXT_OPENGL_PROFILE_MASK,
        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    context_ = egl_.create_context(display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes.data());
    egl_.bind_api(api);
    if (context_ == EGL_NO_CONTEXT)
      fail(ErrorCode::backend_missing, "the EGL driver makes no OpenGL 4.1 core context (error 0x{:x})",
           egl_.get_error());
  }

  GetProcAddress gl_proc_address() const { return reinterpret_cast<GetProcAddress>(egl_.get_proc_address); }

  void make_current() override {
    before_ = {egl_.query_api(), EGL_NO_DISPLAY, EGL_NO_CONTEXT, EGL_NO_SURFACE, EGL_NO_SURFACE};
    egl_.bind_api(EGL_OPENGL_API);
    before_.context = egl_.current_context();
    if (before_.context != EGL_NO_CONTEXT) {
      before_.display = egl_.current_display();
      before_.draw = egl_.current_surface(EGL_DRAW);
      before_.read = egl_.current_surface(EGL_READ);
    }
    if (egl_.make_current(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_FALSE) {
      const EGLint error = egl_.get_error();
      egl_.bind_api(before_.api);
      fail(ErrorCode::backend_missing,
           "eglMakeCurrent failed with error 0x{:x} (is the context used on another thread?)", error);
    }
  }

  void release() noexcept override {
    if (before_.context != EGL_NO_CONTEXT)
      egl_.make_current(before_.display, before_.draw, before_.read, before_.context);
    else
      egl_.make_current(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    egl_.bind_api(before_.api);
  }

  struct Before {
    EGLenum api = EGL_OPENGL_ES_API;
    EGLDisplay display = EGL_NO_DISPLAY;
    EGLContext context = EGL_NO_CONTEXT;
    EGLSurface draw = EGL_NO_SURFACE, read = EGL_NO_SURFACE;
  };
  Egl egl_;
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
  Before before_;
};

GlCandidate candidate(std::string name, EGLenum platform, EGLint device) {
  return {name, [=] { return std::make_unique<EglContext>(name, platform, device); }};
}

}  // namespace

std::vector<GlCandidate> egl_candidates() {
  std::vector<GlCandidate> candidates;
  try {
    const Egl egl;
    EGLint count = 0;
    if (egl.client_has("EGL_EXT_platform_device")) egl.devices(count);
    for (EGLint device = 0; device < count; ++device)
      candidates.push_back(candidate(fmt::format("egl device {}", device), EGL_PLATFORM_DEVICE_EXT, device));
    if (count == 0 || egl.client_has("EGL_MESA_platform_surfaceless"))
      candidates.push_back(candidate("egl surfaceless", EGL_PLATFORM_SURFACELESS_MESA, 0));
  } catch (const Error& error) {
    const std::string reason = error.what();
    candidates.push_back(
        {"egl", [reason]() -> std::unique_ptr<GlContext> { fail(ErrorCode::backend_missing, "{}", reason); }});
  }
  return candidates;
}

}  // namespace uwv
