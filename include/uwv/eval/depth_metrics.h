// SPDX-License-Identifier: Apache-2.0
// How right a depth map is, how sharp its edges are, and how quietly it stands over time.
//
// Depth 0 is invalid and never compared; what share could be compared is said instead. All pictures of one comparison
// have one size, or std::invalid_argument. Means over nothing are NaN.
#pragma once

#include <span>

#include "uwv/core/camera.h"
#include "uwv/core/image.h"
#include "uwv/core/mask.h"

namespace uwv {

/// What the estimate is forgiven before it is judged.
enum class DepthFit {
  none,         ///< Nothing: metric depth.
  scale,        ///< One factor: the median of truth / estimate.
  scale_shift,  ///< A line in inverse depth, by least squares: what networks of relative depth need.
};

/// Errors over the pixels where both are valid and the mask (null = all) is 1.
struct DepthErrors {
  double abs_rel = 0;           ///< Mean |estimate - truth| / truth.
  double rmse = 0;              ///< Root mean square of estimate - truth, scene units.
  double delta_125 = 0;         ///< Share with max(estimate / truth, truth / estimate) < 1.25.
  double scale = 1, shift = 0;  ///< What was forgiven; of inverse depth for `scale_shift`.
  std::size_t pixels = 0;       ///< How many were compared.
  double valid_share = 0;       ///< `pixels` among those where truth is valid and the mask 1.
};

/// With `scale_shift`, pixels the line puts behind infinity count as not valid; a line that cannot be found (fewer than
/// two depths, all alike) falls back to `scale`.
DepthErrors compare_depth(const DepthMap& estimate, const DepthMap& truth, DepthFit fit = DepthFit::none,
                          const ValidityMask* mask = nullptr);

struct DepthEdgeOptions {
  /// Neighbours whose depths differ by more than this share of the nearer one have an edge between them.
  double ratio = 0.1;
  /// An edge is found when the other picture has one within so many pixels (along rows and columns, diagonals
  /// included). 1 forgives the pixel an edge may fall to either side of.
  int tolerance = 1;
  void check() const;
};

/// Depth edges found and missed. An edge is on the nearer of two pixels.
struct DepthEdgeScore {
  std::size_t estimated = 0, true_edges = 0;  ///< Edge pixels of either picture.
  double precision = 0;                       ///< Share of estimated edges that have a true one close by.
  double recall = 0;                          ///< Share of true edges that have an estimated one close by.
  double f = 0;                               ///< Harmonic mean of both; 1 when there are no edges in either.
};
/// Where the mask (null = all) is 0, and where the truth is invalid, nothing is an edge in either picture.
DepthEdgeScore compare_depth_edges(const DepthMap& estimate, const DepthMap& truth,
                                   const DepthEdgeOptions& options = {}, const ValidityMask* mask = nullptr);
/// Of all edges of several pictures together; a picture without edges changes nothing.
DepthEdgeScore pooled(std::span<const DepthEdgeScore> scores);

struct FlickerOptions {
  /// A point that lands on a depth differing by more than this share is taken for hidden or newly seen, not for
  /// flickering; `jump_share` says how many were.
  double jump = 0.25;
  void check() const;
};

/// How much the depth of points at rest changes from each frame to the next.
struct DepthFlicker {
  double mean = 0;         ///< Mean |found - predicted| / predicted.
  double bias = 0;         ///< Mean (found - predicted) / predicted: breathing of the whole picture.
  double jump_share = 0;   ///< Points left out as hidden, among those that landed on a depth.
  std::size_t points = 0;  ///< How many were compared.
};

/// Every pixel of a frame is carried into the next by the cameras and its depth compared with the one found there
/// (linear in inverse depth between the four pixels around; points beside an edge or an invalid depth don't land).
/// `at_rest`: one mask a frame, 1 = does not move; empty = all at rest. One camera a depth map, of its size.
DepthFlicker temporal_flicker(std::span<const DepthMap> depth, std::span<const Camera> cameras,
                              std::span<const ValidityMask> at_rest = {}, const FlickerOptions& options = {});

}  // namespace uwv
