// SPDX-License-Identifier: Apache-2.0
// Depth where none can be measured (a photo, a locked-off shot): layers that stand on a ground plane.
//
// An assumption, not a measurement. The camera stands upright at eye height; below the horizon lies level ground, which
// ends at an upright backdrop; the sky is far; each connected piece of foreground stands upright where its lowest pixel
// touches the ground, and bulges a little. What is assumed is drawn from the picture where it can be: the horizon from
// vanishing lines, the end of the ground from a change of colour (column by column where that is clear: a street has
// sides), the sky from its colour, smoothness and brightness.
//
// Axes of the level world used inside: x right, y down (gravity), z level and forward. The camera looks down by
// `pitch`, so the horizon is at v = cy - fy * tan(pitch). Depth is along the optical axis as everywhere.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "uwv/geometry/layers.h"

namespace uwv {

/// What spoke for a sky and against it, of the smooth, pale or blue pixels that join the upper edge.
struct SkyEvidence {
  double share = 0;          ///< Of the picture.
  double of_edge = 0;        ///< Of the upper edge.
  double contrast = 0;       ///< Median brightness over that of the rest: walls are lit as the room is, skies light it.
  double blue_over_red = 0;  ///< Median.
  bool believed = false;
};

struct PlanarPriorOptions {
  /// Row of the horizon, in pixels from the top edge; may lie outside the picture. Empty = vanishing lines, else the
  /// lower end of a level sky, else the middle.
  std::optional<double> horizon_row;
  /// Row where the ground ends at the backdrop. Empty = the strongest level change of colour, else default_ground.
  std::optional<double> backdrop_row;
  /// Row where the ground ends in every column of the picture, in pixels from the upper edge. Empty = found by colour
  /// where neither this nor backdrop_row is given and the camera is locked off, else a level line.
  std::vector<double> contour;
  bool find_contour = true;  ///< false = a level line.
  /// Tilt of the ground against the line of sight, in degrees, at which it ends at the latest: renderers drop what is
  /// steeper (--max-tilt), which leaves stripes. In (0, 90).
  double steepest_ground = 85.5;
  double camera_height = 1.6;  ///< Eye height; in metres it makes depth roughly metric, as depth networks give.
  double median_depth = 0;     ///< > 0: all depth is scaled so that the first frame's median is this. 0 = no scaling.
  /// Where the ground ends without a cue, as a share of what lies between horizon and lower edge. Smaller: a farther
  /// backdrop, more parallax between it and the foreground.
  double default_ground = 0.25;
  double sky_distance = 6.0;  ///< Of the sky, times the backdrop's. Finite: renderers weigh by depth. >= 1.
  double nearest = 0.25;      ///< Least distance of a foreground, as a share of the backdrop's.
  double farthest = 0.8;      ///< Greatest, so that foreground stays clear of the backdrop. In [nearest, 1).
  double relief = 0.5;        ///< Half thickness of a foreground, times half its width. 0 = cardboard; 1 = a ball.
  int contact_window = 9;     ///< Frames to each side that steady where a foreground touches the ground. 0 = none.
  double min_piece = 0.002;   ///< Pieces smaller than this share of the picture stand with the nearest larger piece.
  bool locked_off = true;     ///< The camera does not move: one backdrop serves all frames and cannot flicker.
  int backdrop_samples = 9;   ///< Frames whose median shows the backdrop of a locked-off clip.
  bool find_sky = true;       ///< false = backdrop up to the upper edge.
  /// Throws std::invalid_argument when a value is out of range.
  void check() const;
};

/// What told a row of the layout.
enum class LayoutCue { given, vanishing_lines, sky, colour, assumed };
std::string_view to_string(LayoutCue cue);

struct PlanarPriorResult {
  /// Depth everywhere > 0 and finite, confidence 0.1 (sky) to 0.3 (ground): never a measurement. Every camera is the
  /// identity pose: the world is the camera's frame.
  SceneGeometry geometry;
  double horizon_row = 0;
  LayoutCue horizon_from = LayoutCue::assumed;
  double backdrop_row = 0;
  LayoutCue backdrop_from = LayoutCue::assumed;
  double pitch = 0;              ///< Radians, > 0 looks down.
  double camera_height = 0;      ///< In the unit of depth, after scaling.
  double backdrop_distance = 0;  ///< Level distance, in the unit of depth.
  double sky_share = 0;          ///< Of the first frame.
  SkyEvidence sky;               ///< Of the picture that shows the backdrop.
  std::vector<double> contour;   ///< As in the options, for every column. Empty where the ground ends at a level line.
  double foreground_share = 0;   ///< Mean over frames.
  /// One line for a log.
  std::string brief() const;
};

/// `foreground` has as many masks as there are frames, or none (no foreground at all). All sizes are equal. Throws
/// std::invalid_argument otherwise, and when there are no frames or the intrinsics are not positive and finite.
/// Memory: 8 bytes a pixel and frame for the result, and a few pictures.
PlanarPriorResult planar_prior(std::span<const ImageRgb> frames, std::span<const ForegroundMask> foreground,
                               const Intrinsics& intrinsics, const PlanarPriorOptions& options, ThreadPool& pool,
                               Monitor& monitor);

}  // namespace uwv
