// SPDX-License-Identifier: Apache-2.0
#include "uwv/core/matrix_library.h"

#include <gtest/gtest.h>

namespace uwv {
namespace {

TEST(MatrixLibrary, WithoutLibtorchNothingIsReplaced) {
  const MatrixLibrary library = matrix_library();
  EXPECT_TRUE(library.torch.empty());
  EXPECT_FALSE(library.replaced());
}

TEST(MatrixLibrary, AnotherThanLibtorchsOwnIsAReplacement) {
  EXPECT_TRUE((MatrixLibrary{"/lib/libblas.so.3", "/torch/libtorch_cpu.so"}.replaced()));
  EXPECT_FALSE((MatrixLibrary{"/torch/libtorch_cpu.so", "/torch/libtorch_cpu.so"}.replaced()));
  EXPECT_FALSE((MatrixLibrary{"/lib/libblas.so.3", ""}.replaced()));
}

}  // namespace
}  // namespace uwv
