// SPDX-License-Identifier: Apache-2.0
// Which pixels of a finished rendering show a surface they should not, and which should show one and don't.
//
// The rendering's depth is held against the scene along each target pixel's ray. A valid pixel is right when its depth
// lies between the least and the greatest true depth of the 3x3 pixels around, give or take a relative tolerance: so
// silhouettes may be off by a pixel and slanted surfaces by a footprint. A deeper pixel looks through something, and it
// matters whether the source could have told: a surface is *known* where a source camera sees it (inside its picture,
// unobstructed) and *barely known* where that happens only within one pixel of a silhouette in the source's picture.
#pragma once

#include <span>

#include "uwv/core/mask.h"
#include "uwv/core/thread_pool.h"
#include "uwv/eval/synthetic_scene.h"

namespace uwv {

struct WrongSurfaceOptions {
  /// Relative depth error that still counts as the same surface. 2 % is well below the distances between the objects
  /// of the stock scenes and above what any kernel's interpolation does within one surface.
  double depth_tolerance = 0.02;
  /// Whether a surface shows its front or its back is not judged when |cos| of the angle between normal and line of
  /// sight is below this, from source or target: there a pixel's footprint holds both.
  double grazing = 0.05;
  void check() const;
};

/// Counts of target pixels.
struct WrongSurface {
  std::size_t valid = 0;  ///< Pixels the rendering shows.

  // Each valid pixel that is not right counts in exactly one of these:
  std::size_t through_known = 0;    ///< Shows background through a known surface. Avoidable.
  std::size_t through_unknown = 0;  ///< Shows background through a surface no source ever saw. Unavoidable.
  std::size_t through_border = 0;   ///< As through_known, but only barely known surfaces are in the way.
  std::size_t back_faces = 0;       ///< Shows a surface from behind, which a source saw from the front. Avoidable.
  std::size_t floating = 0;         ///< Nearer than any true surface: stretched pixels hanging in the air.

  // Holes, outside a one-pixel band around changes of surface or of what is known:
  std::size_t known = 0;  ///< Pixels whose true surface is known, from the side the target sees.
  std::size_t holes = 0;  ///< Of these, pixels the rendering does not show.

  /// The avoidable mistakes through_known and back_faces as a share of valid pixels; 0 when none is valid.
  double wrong_share() const;
  /// holes / known; 0 when nothing is known.
  double hole_share() const;
};

/// `depth` (0 = invalid) and `valid` are the rendering seen by `target`; only pixels with both count as shown.
/// `sources` are the cameras whose frames it was made from, all filming at `time`. Throws std::invalid_argument when
/// sizes differ or there is no source.
WrongSurface wrong_surface(const Scene& scene, double time, const Camera& target, std::span<const Camera> sources,
                           const DepthMap& depth, const ValidityMask& valid, ThreadPool& pool,
                           const WrongSurfaceOptions& options = {});

}  // namespace uwv
