// SPDX-License-Identifier: Apache-2.0
// The background layer: the clip as it would be without its foreground (paper, "Layer-wise Point Cloud Construction").
//
// What the foreground hides is first looked for in other frames that saw it: at the same place when the camera does not
// move, else through homographies of the background from frame to frame (right for far or flat backgrounds and turning
// cameras; where near things have parallax it is an approximation). Its exposure is matched, and several sightings give
// their median. What no frame saw is invented once, by inpainting, and carried from frame to frame, so that it stays.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "uwv/geometry/layers.h"

namespace uwv {

struct CompletionOptions {
  bool camera_moves = false;  ///< False is faster and cleaner; structure_from_motion.h tells which it is.
  int margin_px = 3;      ///< The foreground is widened by this: its outline is blended with it, and it casts shade.
  int max_samples = 15;   ///< Sightings whose median is taken, spread over the clip. More: less noise and ghosts.
  int reach_frames = 60;  ///< With a moving camera, how far away in time sightings are looked for.
  bool match_exposure = true;  ///< Scale each sighting's channels to the brightness of the frame it fills.
  int inpaint_radius = 4;      ///< Pixels around a missing one that its colour is made of. More: smoother and slower.
  /// Holes are invented at a size no larger than this (longer side) and enlarged: inpainting large holes is blurry
  /// anyway, and takes time in proportion to their area.
  int inpaint_side = 480;
  void check() const;
};

/// Where a pixel of the background layer comes from.
enum class BackgroundOrigin : std::uint8_t {
  own = 0,       ///< This very frame: no foreground here.
  seen = 1,      ///< Another frame saw it.
  invented = 2,  ///< No frame did.
};

struct BackgroundClip {
  std::vector<ImageRgb> frames;               ///< The clip without foreground.
  std::vector<Image<std::uint8_t>> origin;    ///< BackgroundOrigin, a frame.
  double share_seen = 0, share_invented = 0;  ///< Of all pixels of all frames.
  std::vector<std::string> notes;
  std::string brief() const;
};

/// As many masks as frames, all of one size, else std::invalid_argument. Needs 4 bytes a pixel and frame for the result
/// besides the input, which must be there as a whole: what hides now may be seen only at the end. The result does not
/// depend on the number of threads.
BackgroundClip complete_background(std::span<const ImageRgb> frames, std::span<const ForegroundMask> foreground,
                                   const CompletionOptions& options, ThreadPool& pool, Monitor& monitor);

}  // namespace uwv
