// SPDX-License-Identifier: Apache-2.0
#include "uwv/render/gl_context.h"

#include <array>

#include "render/gl_api.h"
#include "render/gl_backends.h"
#include "uwv/core/error.h"

namespace uwv {
namespace {

class AdoptedContext final : public GlContext {
 public:
  explicit AdoptedContext(GetProcAddress get_proc_address) : GlContext("adopted") { load(get_proc_address); }

 private:
  void make_current() override {}
  void release() noexcept override {}
};

}  // namespace

std::string_view to_string(GlBackend backend) {
  switch (backend) {
    case GlBackend::automatic: return "auto";
    case GlBackend::egl: return "egl";
    case GlBackend::osmesa: return "osmesa";
  }
  return "unknown";
}

GlBackend parse_gl_backend(std::string_view name) {
  for (const GlBackend backend : {GlBackend::automatic, GlBackend::egl, GlBackend::osmesa})
    if (to_string(backend) == name) return backend;
  fail(ErrorCode::value_invalid, "'{}' is no OpenGL backend; auto, egl or osmesa is wanted", name);
}

GlContext::GlContext(std::string name) : name_(std::move(name)) {}
GlContext::~GlContext() = default;

bool GlContext::is_software() const {
  for (const std::string_view emulator : {"llvmpipe", "softpipe", "swrast", "SWR", "Software Rasterizer"})
    if (renderer_.find(emulator) != std::string::npos) return true;
  return false;
}

void GlContext::load(GetProcAddress get_proc_address) {
  api_ = std::make_unique<const GlApi>(load_gl_api(get_proc_address));
  renderer_ = reinterpret_cast<const char*>(api_->GetString(GL_RENDERER));
  version_ = reinterpret_cast<const char*>(api_->GetString(GL_VERSION));
}

GlCurrent::GlCurrent(GlContext& context) : context_(context) {
  if (context_.current_depth_ == 0) context_.make_current();
  ++context_.current_depth_;
}

GlCurrent::~GlCurrent() {
  if (--context_.current_depth_ == 0) context_.release();
}

std::vector<GlCandidate> gl_candidates(GlBackend backend) {
  std::vector<GlCandidate> candidates;
  if (backend != GlBackend::osmesa) candidates = egl_candidates();
  if (backend != GlBackend::egl) candidates.push_back(osmesa_candidate());
  return candidates;
}

std::vector<GlProbe> probe_gl_backends() {
  std::vector<GlProbe> probes;
  for (const GlCandidate& candidate : gl_candidates(GlBackend::automatic)) {
    GlProbe probe{candidate.name, false, {}, {}, {}};
    try {
      const std::unique_ptr<GlContext> context = candidate.open();
      probe.renderer = context->renderer();
      probe.version = context->version();
      probe.usable = true;
    } catch (const Error& error) {
      probe.reason = error.what();
    }
    probes.push_back(std::move(probe));
  }
  return probes;
}

std::unique_ptr<GlContext> make_gl_context(GlBackend backend) {
  std::unique_ptr<GlContext> emulated;
  std::string tried;
  for (const GlCandidate& candidate : gl_candidates(backend)) {
    try {
      std::unique_ptr<GlContext> context = candidate.open();
      if (!context->is_software()) return context;
      if (emulated == nullptr) emulated = std::move(context);
    } catch (const Error& error) {
      tried += fmt::format("{}{}: {}", tried.empty() ? "" : "; ", candidate.name, error.what());
    }
  }
  if (emulated == nullptr)
    fail(ErrorCode::backend_missing, "no OpenGL context can be made here ({}); use --renderer cpu", tried);
  return emulated;
}

std::unique_ptr<GlContext> adopt_gl_context(void* (*get_proc_address)(const char* name)) {
  return std::make_unique<AdoptedContext>(get_proc_address);
}

}  // namespace uwv
