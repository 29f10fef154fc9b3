// SPDX-License-Identifier: Apache-2.0
// OpenGL without a window. A context is found when the program runs, never when it is built: EGL on a device (a GPU, or
// Mesa's software device), then EGL without any device ("surfaceless"), then OSMesa. The default display is never
// opened: it may belong to someone else's screen, and on a server it hangs or crashes. libEGL and libOSMesa are opened
// at run time, so a machine without them still starts the program. See docs/headless-gl.md.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace uwv {

enum class GlBackend {
  automatic,  ///< EGL on a GPU; else EGL emulated by the processor; else OSMesa.
  egl,        ///< EGL only.
  osmesa,     ///< Mesa's off-screen library only; always emulated by the processor.
};

/// Names as on the command line; parse throws Error(value_invalid) listing the known names.
std::string_view to_string(GlBackend backend);
GlBackend parse_gl_backend(std::string_view name);

/// What one way to a context gave on this machine; `uwv_app doctor` prints these.
struct GlProbe {
  std::string name;      ///< "egl device 0", "egl surfaceless", "osmesa".
  bool usable = false;   ///< A context was made and is new enough.
  std::string renderer;  ///< GL_RENDERER when usable.
  std::string version;   ///< GL_VERSION when usable.
  std::string reason;    ///< Why it is not usable, in one sentence; empty when usable.
};

/// The OpenGL entry points of one context; its definition is internal.
struct GlApi;

/// An OpenGL context of at least version 4.1. Made current only for as long as a GlCurrent lives, so it may move
/// between threads, as long as only one uses it at a time.
class GlContext {
 public:
  virtual ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  const std::string& name() const { return name_; }          ///< As in GlProbe::name, or "adopted".
  const std::string& renderer() const { return renderer_; }  ///< GL_RENDERER.
  const std::string& version() const { return version_; }    ///< GL_VERSION.
  /// True when the processor emulates a GPU (llvmpipe, softpipe, swrast): our CPU renderer is then the faster one.
  bool is_software() const;
  /// Entry points; to be called only while a GlCurrent of this context lives.
  const GlApi& api() const { return *api_; }

 protected:
  explicit GlContext(std::string name);
  using GetProcAddress = void* (*)(const char* name);
  /// Reads entry points, names and version. Call once, in the derived constructor, with the context current. Throws
  /// Error(backend_missing) when the context is too old or lacks a function.
  void load(GetProcAddress get_proc_address);

 private:
  friend class GlCurrent;
  virtual void make_current() = 0;
  virtual void release() noexcept = 0;

  std::string name_, renderer_, version_;
  std::unique_ptr<const GlApi> api_;
  int current_depth_ = 0;
};

/// Makes a context current on this thread while it lives, then brings back what was current before (EGL), or leaves
/// none. Scopes of one context nest.
class GlCurrent {
 public:
  explicit GlCurrent(GlContext& context);
  ~GlCurrent();
  GlCurrent(const GlCurrent&) = delete;
  GlCurrent& operator=(const GlCurrent&) = delete;

 private:
  GlContext& context_;
};

/// Tries every way to a context, in the order `GlBackend::automatic` prefers them.
std::vector<GlProbe> probe_gl_backends();

/// The first context that works, GPUs before emulation. Throws Error(backend_missing) naming what was tried and why
/// each failed.
std::unique_ptr<GlContext> make_gl_context(GlBackend backend = GlBackend::automatic);

/// A context made and kept current by the caller (a window's, say); `get_proc_address` is its toolkit's look-up
/// (glfwGetProcAddress). It is neither made current nor destroyed by us, and must be current on the calling thread
/// whenever something that uses it is called or destroyed. Throws Error(backend_missing) when it is too old.
std::unique_ptr<GlContext> adopt_gl_context(void* (*get_proc_address)(const char* name));

}  // namespace uwv
