// SPDX-License-Identifier: Apache-2.0
#include "uwv/core/matrix_library.h"

#include <dlfcn.h>

namespace uwv {
namespace {

constexpr const char* product = "sgemm_";  // BLAS, single precision

std::string file_of(void* symbol) {
  Dl_info info{};
  return symbol != nullptr && dladdr(symbol, &info) != 0 ? info.dli_fname : "";
}

}  // namespace

MatrixLibrary matrix_library() {
  MatrixLibrary library{file_of(dlsym(RTLD_DEFAULT, product)), {}};
  void* const torch = dlopen("libtorch_cpu.so", RTLD_LAZY | RTLD_NOLOAD);
  if (torch == nullptr) return library;
  library.torch = file_of(dlsym(torch, product));
  if (library.torch.find("libtorch") == std::string::npos) library.torch.clear();
  dlclose(torch);
  return library;
}

}  // namespace uwv
