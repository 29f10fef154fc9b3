// SPDX-License-Identifier: Apache-2.0
// Which depths can be trusted: the filter that drops pixels on depth edges, where estimators smear foreground into
// background and a point cloud tears.
#pragma once

#include "uwv/core/mask.h"
#include "uwv/core/thread_pool.h"

namespace uwv {

/// The official filter (geometry sheet, section 4.3): within a window, (max - min) / (mean + 1e-6) must stay below a
/// ratio.
struct ReliabilityOptions {
  /// Off keeps every valid depth (the paper's default M^s of ones).
  bool enabled = true;
  /// Window side in pixels, odd. 5 is what the official code uses.
  int window = 5;
  /// `depth_reliable_ratio_thresh` of the official code, whose callers all pass 0.1.
  float ratio = 0.1F;
  /// The official mean counts the zero padding outside the picture, which makes borders stricter (mean x 0.6 at edges,
  /// x 0.36 at corners). True reproduces that; false averages only what is there.
  bool count_padding = true;
  void check() const;
};

/// 1 where the depth is valid and does not vary much around. Invalid depths (0) take part in min and mean as zeros, as
/// in the official code, so pixels next to them are dropped too.
ValidityMask reliable_depth(const DepthMap& depth, const ReliabilityOptions& options, ThreadPool& pool);
/// The same into a mask that is used again and again.
void reliable_depth(const DepthMap& depth, const ReliabilityOptions& options, ThreadPool& pool, ValidityMask& out);

}  // namespace uwv
