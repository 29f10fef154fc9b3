// SPDX-License-Identifier: Apache-2.0
// The background layer of a clip filmed by a moving camera: colour and depth of the static scene behind what moves.
//
// Other frames saw the hidden places from elsewhere or at another time. Their static points are moved into this frame
// by their depth and the cameras, with a depth test; where several agree on a surface, it is the one that would be
// seen. Colour is then looked up in those frames that see this very surface, with their exposure matched, and the
// median taken. Depth that nobody saw is continued smoothly from around it (harmonic in inverse depth, which continues
// planes exactly where they surround the hole); colour that nobody saw is inpainted once and carried from frame to
// frame. background_completion.h serves cameras that stand or turn, where no depth is needed.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "uwv/geometry/background_completion.h"
#include "uwv/geometry/scene_geometry.h"

namespace uwv {

struct ViewsOptions {
  int margin_px =
      5;  ///< What moves is widened by this: its outline is inexact, blended with what is behind, and shaded.
  /// Within this share of the picture's height from what moves, a sighting counts only where there is no better one:
  /// parts of a moving thing that were not found (a foot that rests while it is stood on) are near those that were.
  double doubt = 0.08;
  /// Other frames that are asked for each frame, spread evenly over `reach_frames` before and after. More: more is
  /// found and less noise, in proportion to the time.
  int views = 12;
  int reach_frames = 40;  ///< Cameras drift, and light changes, over longer times.
  /// Depths that differ by less than this share are the same surface. Estimated depth is good to 2 or 3 percent.
  double depth_tolerance = 0.05;
  bool match_exposure = true;  ///< Scale each frame's channels to the brightness of the one it fills.
  int inpaint_radius = 4;      ///< As in CompletionOptions.
  int inpaint_side = 480;      ///< As in CompletionOptions.
  /// Throws std::invalid_argument when a value is out of range.
  void check() const;
};

struct ViewsBackground {
  std::vector<ImageRgb> frames;               ///< The clip without what moves.
  std::vector<DepthMap> depth;                ///< Of the static scene; 0 only where nothing static is known to go by.
  std::vector<Image<std::uint8_t>> origin;    ///< BackgroundOrigin of the colour, a frame.
  double share_seen = 0, share_invented = 0;  ///< Of all pixels of all frames.
  double seconds = 0;
  std::vector<std::string> notes;
  std::string brief() const;  ///< One line.
};

/// As many cameras, geometries and masks as frames, all of one size, else std::invalid_argument. `foreground` is what
/// moves; depth under it is not used. Depth that is NaN, infinite or not positive is unknown. Needs 8 bytes a pixel and
/// frame for the result. Reports stages "background: sightings" and "background: inventing". The result does not depend
/// on the number of threads, and its colours not on the unit of depth.
ViewsBackground background_from_views(std::span<const ImageRgb> frames, std::span<const Camera> cameras,
                                      std::span<const FrameGeometry> geometry,
                                      std::span<const ForegroundMask> foreground, const ViewsOptions& options,
                                      ThreadPool& pool, Monitor& monitor);

}  // namespace uwv
