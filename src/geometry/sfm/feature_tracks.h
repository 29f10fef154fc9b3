// SPDX-License-Identifier: Apache-2.0
// Points of the scene followed from frame to frame.
#pragma once

#include <Eigen/Core>
#include <span>
#include <utility>
#include <vector>

#include "uwv/core/image.h"
#include "uwv/core/monitor.h"
#include "uwv/core/thread_pool.h"
#include "uwv/geometry/structure_from_motion.h"

namespace uwv::sfm {

/// One point in consecutive frames. Pixels of the full picture, centres at +0.5.
struct Track {
  int first = 0;
  std::vector<Eigen::Vector2d> pixels;
  int last() const { return first + static_cast<int>(pixels.size()) - 1; }
  bool covers(int frame) const { return frame >= first && frame <= last(); }
  const Eigen::Vector2d& at(int frame) const { return pixels[static_cast<std::size_t>(frame - first)]; }
};

struct Tracks {
  std::vector<Track> tracks;
  std::vector<int> cuts;  ///< Frames at which another shot begins.
  /// Median shift between each frame and the one before, pixels; 0 at the first frame and at cuts.
  std::vector<double> shift_px;
};

/// Corners followed by pyramidal Lucas-Kanade, kept where following them back returns to the start. Tracks end at cuts.
Tracks follow_features(std::span<const ImageRgb> frames, const SfmOptions& options, ThreadPool& pool, Monitor& monitor);

/// A track seen in two frames.
struct Pair {
  std::size_t track;
  Eigen::Vector2d a, b;
};
std::vector<Pair> common_tracks(const std::vector<Track>& tracks, int frame_a, int frame_b);

/// 0 for none.
double median(std::vector<double> values);

}  // namespace uwv::sfm
