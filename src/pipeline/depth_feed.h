// SPDX-License-Identifier: Apache-2.0
// Depth of the clip's frames at the working size, from depth files or from stereo disparity.
#pragma once

#include <memory>

#include "uwv/core/depth.h"
#include "uwv/core/monitor.h"
#include "uwv/io/depth_source.h"
#include "uwv/pipeline/run_options.h"

namespace uwv::pipeline {

class DepthFeed {
 public:
  /// `full_size` and `intrinsics` belong to the clip's full-size picture; `clip_frames` must be covered. Throws Error
  /// when no depth is given, or it has fewer frames than the clip.
  DepthFeed(const RunOptions& options, Size full_size, Size working_size, const Intrinsics& full_intrinsics,
            long clip_frames, Monitor& monitor);

  /// Depth of the clip's frame `index`.
  void read(long index, DepthMap& depth);

 private:
  void disparity_to_depth(DepthMap& disparity) const;
  static void invert(DepthMap& inverse_depth);

  std::unique_ptr<DepthSource> source_;
  std::string path_;
  Size full_size_, working_size_;
  bool single_ = false;
  bool is_disparity_ = false, is_inverse_ = false;
  double fx_times_baseline_ = 0, doffs_ = 0;
};

}  // namespace uwv::pipeline
