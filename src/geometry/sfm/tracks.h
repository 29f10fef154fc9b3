// SPDX-License-Identifier: Apache-2.0
// Point tracks of a clip, in pixels of the tracked (possibly shrunk) picture, centres at +0.5.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "uwv/core/image.h"

namespace uwv::sfm {

/// One feature followed without a gap: pixels[i] is where frame first + i shows it.
struct Track {
  int first = 0;
  std::vector<Eigen::Vector2d> pixels;
  int end() const { return first + static_cast<int>(pixels.size()); }
  bool in(int frame) const { return frame >= first && frame < end(); }
  const Eigen::Vector2d& at(int frame) const { return pixels[static_cast<std::size_t>(frame - first)]; }
};

struct TrackedClip {
  Size size;  ///< Of the tracked picture.
  int frames = 0;
  std::vector<Track> tracks;
  std::vector<int> cuts;  ///< First frames of later shots, ascending. No track crosses one.
};

/// A pair of places, in two frames, of the tracks seen in both.
struct PairMatches {
  std::vector<int> track;
  std::vector<Eigen::Vector2d> a, b;
  std::size_t size() const { return track.size(); }
};
PairMatches matches_between(const std::vector<Track>& tracks, int frame_a, int frame_b);

/// The tracks inside [begin, end), renumbered so that `begin` is frame 0; those of one frame only are left out.
std::vector<Track> tracks_of_shot(const TrackedClip& clip, int begin, int end);

/// 0..count-1 in an order that depends on the seed alone. RANSAC draws its samples by place, always the same ones:
/// lists given to it in this order make the draw the seed's.
std::vector<std::size_t> drawing_order(std::size_t count, std::uint64_t seed);

/// The middle value; of an empty list 0.
double median(std::vector<double> values);

}  // namespace uwv::sfm
