// SPDX-License-Identifier: Apache-2.0
// Imported normals of the clip's frames, as slopes at the working size.
#pragma once

#include <vector>

#include "uwv/geometry/slopes.h"
#include "uwv/io/npy.h"
#include "uwv/pipeline/run_options.h"

namespace uwv::pipeline {

class NormalFeed {
 public:
  /// options.normals names an array of shape (h, w, 3) for a single frame or (n, h, w, 3). Throws Error when it is
  /// anything else or does not cover the clip's frames.
  NormalFeed(const RunOptions& options, Size working_size, long clip_frames);

  SlopeMap read(long index, const Intrinsics& intrinsics);

 private:
  NpyArrayReader reader_;
  Size stored_size_, working_size_;
  bool single_;
  long start_, stride_;
  std::vector<float> values_;
};

}  // namespace uwv::pipeline
