// SPDX-License-Identifier: Apache-2.0
// What moves by itself in a clip whose camera moves too: which pixels, and how deep they are.
//
// A static point seen from two known cameras lands on a known line segment: from where it would land infinitely far
// away to where it would land at the nearest possible depth (a point when its depth is known). Dense optical flow says
// where it did land. The distance between the two, in units of what the flow can be off by, is the evidence of motion;
// several frame distances are put together, since slow things show over long ones and fast things are only followed
// over short ones. An object that moves along its own epipolar line at a speed that mimics a possible depth cannot be
// told from a static one without knowing depth.
//
// Depth of what moves cannot be triangulated. It is taken from where the object touches the reconstructed ground.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "uwv/core/camera.h"
#include "uwv/core/image.h"
#include "uwv/core/mask.h"
#include "uwv/core/monitor.h"
#include "uwv/core/thread_pool.h"
#include "uwv/geometry/layers.h"
#include "uwv/geometry/scene_geometry.h"

namespace uwv {

struct MovingOptions {
  /// Pictures taller than this are shrunk to it for optical flow: 240 is half of a 480-row clip. More: finer outlines
  /// and smaller objects, time grows with the square.
  int flow_height = 240;
  /// How many frame distances are compared, both ways in time; each is twice the one before: 3 = 1, 2 and 4. More:
  /// slower motion is found, time grows in proportion.
  int distances = 3;
  /// What flow and cameras are off by where everything goes well, in pixels of the shrunk picture. Dense inverse search
  /// is good to a quarter of a pixel on texture; the rest is the cameras'.
  double noise_px = 0.4;
  /// How many times its uncertainty a pixel must be off to count as moving in one pair. 3 keeps false alarms rare;
  /// three quarters of it, on average over the pairs, begin a region.
  double significance = 3;
  /// Share of the significance that is enough beside a pixel that has it all (hysteresis).
  double grow = 0.5;
  /// Depths of `coarse` are right within this share.
  double depth_tolerance = 0.05;
  /// Smaller regions are taken for noise; share of the picture. 0.0005 is 14 x 14 pixels of 832 x 480.
  double smallest = 0.0005;
  /// A piece of the given foreground is taken as a whole when this share of it was found to move: not all of what moves
  /// shows, but a thing at rest that a moving one touches in the picture is not to be taken along.
  double agreement = 0.5;
  /// Frames before and after over which that share is averaged: an animal that pauses in mid-stride stays whole, one
  /// that stands still for longer is part of the static scene, and measured.
  int agreement_frames = 8;
  /// Things seen to move in fewer frames than this (or the clip has) are taken for errors of the flow.
  int least_frames = 3;
  /// Holes in a region up to this share of its area belong to it: the inside of a plain, slow thing shows no motion.
  double hole = 0.1;
  /// Throws std::invalid_argument when a value is out of range.
  void check() const;
};

/// Which pixels belong to the static scene.
struct MovingPixels {
  std::vector<ValidityMask> static_pixels;  ///< One per frame, sized as the frames: 1 = static (or not known to move).
  std::vector<double> moving_shares;        ///< Per frame, 0..1.
  double moving_share = 0;                  ///< Mean of the above.
  int regions = 0;                          ///< Connected moving regions that last, summed over the frames.
  double judged_share = 0;                  ///< Share of the pixels for which flow was good enough to say anything.
  double seconds = 0;
  std::vector<std::string> notes;  ///< One sentence each: what limits the answer.
  std::string brief() const;       ///< One line.
};

/// `cameras`: one per frame, sized as the frames. `coarse`: empty or one per frame; depths with a confidence below 0.5
/// are not used. `foreground`: empty or one mask per frame; what of it moves is taken as a whole, with the mask's
/// outline; what of it stands still stays static, for motion decides. A single frame shows no motion: its mask is all
/// static, with a note. Reports stages "optical flow" and "moving objects". Throws
/// std::invalid_argument for no frames or sizes that disagree. The same on every number of threads.
MovingPixels find_moving_pixels(std::span<const ImageRgb> frames, std::span<const Camera> cameras,
                                std::span<const FrameGeometry> coarse, const MovingOptions& options, ThreadPool& pool,
                                Monitor& monitor, std::span<const ForegroundMask> foreground = {});

/// What find_moving_pixels does with a foreground, for one that was looked for only after motion had been found:
/// `found` is changed. Throws std::invalid_argument when sizes disagree.
void take_foreground_whole(std::span<const ImageRgb> frames, std::span<const ForegroundMask> foreground,
                           const MovingOptions& options, ThreadPool& pool, MovingPixels& found);

struct MovingDepthOptions {
  /// Height of the strip of static scene below an object that the ground is taken from, as a share of the object's
  /// height; at least 6 pixels. Larger: steadier on noisy depth, fooled sooner by things standing in front.
  double contact_strip = 0.25;
  /// Ground is what tilts less than this many radians away from level (camera assumed upright), or less than 30 degrees
  /// from ground so found in other frames. 60 degrees also takes hills and cameras looking down.
  double ground_tilt = 1.05;
  /// Standard deviation, in frames, of the smoothing of an object's inverse depth over time. 0 = none. Contact jumps by
  /// several percent when feet are found in one frame and not in the next.
  double smoothing = 4;
  /// An object stands upright, but no part of it is put more than this share nearer or farther than its foot: animals
  /// seen from above do not stand like a wall.
  double lean = 0.15;
  /// How far an object bulges out of its upright plane, as a share of half its width. 1 = as a ball does.
  double relief = 0.5;
  /// Confidence of a depth taken from contact with the ground; lower ones are derived from it. Never a measurement.
  double confidence = 0.3;
  /// Flow resolution for following objects from frame to frame; see MovingOptions.
  int flow_height = 240;
  /// Throws std::invalid_argument when a value is out of range.
  void check() const;
};

/// How the depth of a moving region was come by.
enum class MovingDepthSource : std::uint8_t {
  contact,     ///< From the ground it touches.
  size,        ///< No contact in this frame: from contact in another frame and the change of size in the picture.
  background,  ///< No contact in any frame: just in front of what is behind it. A bound, not an estimate.
  none,        ///< No static depth around it in any frame: left 0.
};

/// One object followed over time. Pieces that stay near each other and go the same way are one object: it has one foot.
struct MovingObject {
  int first_frame = 0;
  std::vector<MovingDepthSource> sources;  ///< One per frame from the first.
  std::vector<double> depths;              ///< Of its lowest visible point, scene units; 0 = none.
};

struct MovingDepthSummary {
  std::vector<MovingObject> objects;
  double contact_share = 0;  ///< Share of the moving pixels whose depth comes from contact.
  double unknown_share = 0;  ///< Share of the moving pixels that got no depth.
  double seconds = 0;
  std::vector<std::string> notes;
  std::string brief() const;  ///< One line.
};

/// Gives the pixels that are not static a depth (overwriting what is there) and a confidence of at most
/// options.confidence; static pixels are not touched. `geometry`: one per frame, sized as the frames. Reports stage
/// "moving depth". Throws std::invalid_argument when sizes disagree. The same on every number of threads.
MovingDepthSummary fill_moving_depth(std::span<const ImageRgb> frames, std::span<const Camera> cameras,
                                     std::span<const ValidityMask> static_pixels, const MovingDepthOptions& options,
                                     ThreadPool& pool, Monitor& monitor, std::vector<FrameGeometry>& geometry);

}  // namespace uwv
