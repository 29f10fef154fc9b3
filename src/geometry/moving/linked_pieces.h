// SPDX-License-Identifier: Apache-2.0
// Connected pieces of a clip's masks, linked over time: what is one thing, and for how long it is there.
#pragma once

#include <opencv2/core.hpp>

#include <span>
#include <vector>

#include "uwv/core/mask.h"
#include "uwv/core/thread_pool.h"
#include "uwv/geometry/layers.h"

namespace uwv::moving {

/// Pieces (8-connected) of one picture per frame; a piece belongs to the same chain as every piece of the next frame
/// that lies within `reach` pixels of it. Labels count from 1 in each frame.
class LinkedPieces {
 public:
  /// `masks`: CV_8U, one per frame and of one size; other than 0 = belongs to a piece. Their memory must outlive this.
  LinkedPieces(std::vector<cv::Mat> masks, int reach, ThreadPool& pool);

  int frames() const { return static_cast<int>(masks_.size()); }
  /// Labels (CV_32S, 0 = none) of a frame: worked out anew, since all frames' would take much memory.
  cv::Mat labels(int frame) const;
  /// Number of labels of a frame, 0 included.
  int label_count(int frame) const { return counts_[static_cast<std::size_t>(frame)]; }
  /// The chain of a label other than 0; chains count from 0.
  int chain(int frame, int label) const;
  int chain_count() const { return static_cast<int>(first_.size()); }
  /// Number of frames from the first to the last that a chain lives in.
  int life(int chain) const {
    return last_[static_cast<std::size_t>(chain)] - first_[static_cast<std::size_t>(chain)] + 1;
  }

 private:
  std::vector<cv::Mat> masks_;
  std::vector<int> counts_, offsets_, chain_of_, first_, last_;
};

/// Marks as moving the pieces of the foreground that were found to move: at least the share `agreement` of a piece's
/// pixels, on average over the frames up to `window` before and after, in which it may have moved more or less. What
/// lies beyond such a piece's outline belongs to it where motion and colour say so, or colour alone says so clearly.
void adopt_foreground(std::span<const ImageRgb> frames, std::span<const ForegroundMask> foreground, double agreement,
                      int window, ThreadPool& pool, std::vector<ValidityMask>& static_pixels);

/// Gives back pieces that live for fewer than `least_life` frames (or the clip's length, if that is less) or have fewer
/// than `smallest` pixels. Returns how many pieces are left, over all frames.
int drop_fleeting(int least_life, double smallest, ThreadPool& pool, std::vector<ValidityMask>& static_pixels);

/// Closes what moving pieces enclose, up to a share of the piece's own area.
void close_holes(double share_of_piece, ThreadPool& pool, std::vector<ValidityMask>& static_pixels);

}  // namespace uwv::moving
