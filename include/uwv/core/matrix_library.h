// SPDX-License-Identifier: Apache-2.0
// Which library multiplies this program's matrices. Several bring the same names (BLAS), and the loader gives everybody
// the first one it met: where the system's plain BLAS comes before libtorch's own, the model's float32 products take
// ten times as long, with nothing said. The target uwv::model puts libtorch first; a program linked otherwise is
// warned.
#pragma once

#include <string>

namespace uwv {

struct MatrixLibrary {
  std::string used;   ///< Path of the file that multiplies; empty where no BLAS is loaded.
  std::string torch;  ///< Of libtorch's, where it is loaded and brings its own; else empty.

  /// Whether libtorch is made to use another one than its own.
  bool replaced() const { return !torch.empty() && used != torch; }
};

MatrixLibrary matrix_library();

}  // namespace uwv
