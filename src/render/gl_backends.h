// SPDX-License-Identifier: Apache-2.0
// The ways to a headless context, one function per library.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "uwv/render/gl_context.h"

namespace uwv {

/// One way to a context. `open` throws Error(backend_missing) when it does not work here.
struct GlCandidate {
  std::string name;
  std::function<std::unique_ptr<GlContext>()> open;
};

/// One candidate per EGL device, then the surfaceless platform. When libEGL is missing there is still one candidate,
/// which says so when opened.
std::vector<GlCandidate> egl_candidates();
GlCandidate osmesa_candidate();

/// All candidates of a backend in the order they are tried.
std::vector<GlCandidate> gl_candidates(GlBackend backend);

}  // namespace uwv
