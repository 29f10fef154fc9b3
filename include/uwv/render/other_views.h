// SPDX-License-Identifier: Apache-2.0
// What one frame does not see, other frames of a moving camera may have seen: their measured, static points are moved
// into the same target camera and put where the frame's own cloud leaves pixels open. Together the frames are one
// merged cloud of the static scene, drawn view by view: each view keeps its own surface patches and resampled colours,
// memory stays that of a few pictures, and the frame's own points, which belong to this very moment, always come first.
//
// Depth is tested between all of them. A pixel stays open when
//   - a point of the frame itself lies before what would be shown, even one that is not drawn (seen from behind, say);
//   - the nearest thing any view puts there is turned away from the target camera;
//   - the frame, or a view that is drawn, measured something behind the point along its own line of sight: it sees
//     through the point, so that cannot be there.
#pragma once

#include <memory>

#include "uwv/render/occlusion.h"

namespace uwv {

/// Another frame; everything has camera.size.
struct OtherView {
  long index = 0;  ///< Of the source frame; a view never fills the frame of its own index.
  Camera camera;   ///< In the world of the cameras that fill() is given.
  ImageRgb colour;
  DepthMap depth;  ///< 0 = invalid.
  ValidityMask
      usable;  ///< 1 = static and measured; all other points take no part, nor do those beside a step in depth.
};

struct OtherViewsOptions {
  int max_views = 4;       ///< Drawn for one frame, those first that show most of what is open; 1 to 64.
  double min_gain = 2e-3;  ///< Share of the picture a view has to open up to be drawn, 0 to 1.
  /// Relative difference up to which two depths are of one surface, 0 to 0.5.
  float tolerance = 0.05F;
  /// A view that puts more than this share of what it has in common with the frame before the frame's own surfaces
  /// disagrees about depth or cameras and is left out; 0 to 1.
  double max_contradiction = 0.25;
  /// Views are brought to the frame's exposure, channel by channel, by what both show; at most by this factor, from 1.
  float max_gain = 1.25F;
  /// Throws std::invalid_argument when a value is out of range.
  void check() const;
};

/// What was done for one frame.
struct FillReport {
  std::size_t open = 0;          ///< Pixels the frame left open.
  std::size_t filled = 0;        ///< Of those, shown by other views now.
  std::size_t hidden = 0;        ///< Left open although a view reaches them: something lies before.
  std::size_t contradicted = 0;  ///< Points refused because another frame sees through them.
  int views = 0;                 ///< Drawn.
  int refused = 0;               ///< Left out by max_contradiction.
  double seconds = 0;
};

class OtherViews {
 public:
  /// Both references outlive the object. Of `occlusion`, kernel (bilinear: resample), footprint, slopes, alpha and
  /// normal_filter count. Throws std::invalid_argument for options out of range.
  OtherViews(Rasterizer& rasterizer, ThreadPool& pool, const OcclusionOptions& occlusion,
             const OtherViewsOptions& options);
  ~OtherViews();

  /// Throws std::invalid_argument when sizes disagree.
  void add(OtherView view);
  std::size_t size() const;

  /// Fills open pixels of `frame`, which is `own` rendered into `target`: colour, depth and valid change there. The
  /// same on every number of threads.
  FillReport fill(const SourceFrame& own, const Camera& target, RenderedFrame& frame);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace uwv
