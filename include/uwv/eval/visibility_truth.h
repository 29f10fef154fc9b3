// SPDX-License-Identifier: Apache-2.0
// The truth about M'' and M_vis (Algorithm 1 of the paper) in synthetic scenes, and how well a mask agrees with it.
//
// A source pixel is visible from a target camera when its surface point lies inside the target's picture and no surface
// that the source camera itself sees stands between the target camera and the point. Surfaces the source never saw do
// not count: nothing about them can be known from the source frame. "Sees" means: inside the source's picture and
// unobstructed. Everything is decided by ray casting in double precision through pixel centres.
#pragma once

#include "uwv/core/mask.h"
#include "uwv/core/thread_pool.h"
#include "uwv/eval/synthetic_scene.h"

namespace uwv {

/// 1 = left out of a comparison.
using ExcludedMask = Mask<struct ExcludedTag>;

/// Per source pixel.
struct VisibilityTruth {
  ValidityMask visible;  ///< 1 = visible from the target; 0 also where the source shows no surface.
  /// Where a pixel-sized sample cannot be held to the truth at its centre: pixels with a different truth or another
  /// object among their eight neighbours, and pixels that show no surface.
  ExcludedMask excluded;
};

/// Source and target see the scene at the same time. The pictures may differ in size and lens.
VisibilityTruth visibility_truth(const Scene& scene, const Camera& source, const Camera& target, double time,
                                 ThreadPool& pool);

/// The truth of a path of one source frame: `path` becomes visible where it was and `next` is too. A pixel is excluded
/// where that product rests on an excluded one; once surely hidden, it stays surely hidden.
void accumulate(VisibilityTruth& path, const VisibilityTruth& next);

/// Counts of a mask against a truth; positive means 1.
struct PrecisionRecall {
  std::size_t tp = 0, fp = 0, fn = 0, tn = 0;
  double precision() const;  ///< Of what the mask claims, the share that is true; 1 when it claims nothing.
  double recall() const;     ///< Of what is true, the share the mask claims; 1 when nothing is true.
  double f1() const;         ///< Harmonic mean of both; 0 when both are 0.
};

/// Throws std::invalid_argument when the sizes differ.
PrecisionRecall compare(const ValidityMask& mask, const ValidityMask& truth, const ExcludedMask& excluded);
PrecisionRecall compare(const ValidityMask& mask, const VisibilityTruth& truth);

}  // namespace uwv
