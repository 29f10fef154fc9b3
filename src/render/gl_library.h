// SPDX-License-Identifier: Apache-2.0
// Shared libraries opened at run time.
#pragma once

#include <dlfcn.h>

#include <initializer_list>
#include <string>

namespace uwv {

/// The first of the names that opens, or null with the loader's message. Never closed again: graphics drivers leave
/// threads and exit handlers behind that must not lose their code.
struct GlLibrary {
  void* handle = nullptr;
  std::string reason;

  explicit GlLibrary(std::initializer_list<const char*> names) {
    for (const char* name : names) {
      handle = dlopen(name, RTLD_NOW | RTLD_LOCAL);
      if (handle != nullptr) return;
      if (reason.empty()) reason = dlerror();
    }
  }

  template <class Function>
  bool find(Function& function, const char* name) const {
    function = handle == nullptr ? nullptr : reinterpret_cast<Function>(dlsym(handle, name));
    return function != nullptr;
  }
};

}  // namespace uwv
