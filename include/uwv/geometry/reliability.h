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

/// How sharply a depth map steps from one surface to another. An edge is counted where, along a row or a column,
/// inverse depth changes by more than a tenth within seven pixels and is nearly constant at both ends of them (a floor
/// seen at a grazing angle is not); it is smeared when two pixels or more in between belong to neither
/// end. One alone is what any camera makes of an edge, and the renderer copes with it (SlopeOptions::max_tilt).
struct EdgeSharpness {
  std::size_t edges = 0;
  std::size_t smeared = 0;
  /// 0 when there is no edge.
  double smeared_share() const { return edges > 0 ? static_cast<double>(smeared) / static_cast<double>(edges) : 0.0; }
  /// Whether the filter is worth its price. Of measured and rendered depth 0 to 6 % of the edges are smeared, after a
  /// blur of one pixel's deviation nearly all; docs/performance.md has what the filter costs the one and gains the
  /// other.
  bool smears() const { return smeared_share() > 0.5; }
};
EdgeSharpness edge_sharpness(const DepthMap& depth, ThreadPool& pool);

}  // namespace uwv
