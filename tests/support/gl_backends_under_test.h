// SPDX-License-Identifier: Apache-2.0
// The OpenGL backends a test is repeated for; those absent here are skipped by name.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>

#include "render/gl_backends.h"
#include "uwv/core/error.h"

namespace uwv::testing {

inline constexpr const char* backend_names[] = {"egl device 0", "egl surfaceless", "osmesa"};

/// Null, with the reason, when this backend does not work here.
inline std::unique_ptr<GlContext> open_backend(const std::string& name, std::string& reason) {
  reason = "no such backend is listed";
  for (const GlCandidate& candidate : gl_candidates(GlBackend::automatic)) {
    if (candidate.name != name) continue;
    try {
      return candidate.open();
    } catch (const Error& error) {
      reason = error.what();
    }
  }
  return nullptr;
}

/// "egl device 0" as part of a test's name.
inline std::string as_test_name(std::string name) {
  for (char& c : name)
    if (c == ' ') c = '_';
  return name;
}

}  // namespace uwv::testing
