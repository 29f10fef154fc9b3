// SPDX-License-Identifier: Apache-2.0
// Frames of depth inside a NumPy array.
#pragma once

#include <string>

#include "uwv/core/image.h"
#include "uwv/io/npy.h"

namespace uwv::io {

/// An .npy or .npz array understood as n frames of h x w: shape (h, w), (n, h, w), (n, 1, h, w) or (n, h, w, 1).
class DepthArray {
 public:
  /// `key` as in DepthOptions. Throws Error(value_invalid) for other shapes and for a key that is not there.
  DepthArray(const std::string& path, const std::string& key);

  long frames() const { return frames_; }
  Size size() const { return size_; }
  const NpyHeader& header() const { return reader_.header(); }
  /// Stored values times `scale`, not yet sanitised; 0 <= index < frames().
  void read(long index, double scale, DepthMap& out);

 private:
  NpyArrayReader reader_;
  long frames_ = 1;
  Size size_;
};

/// True when the file starts like an .npy or .npz file.
bool is_numpy_file(const std::string& path);

}  // namespace uwv::io
