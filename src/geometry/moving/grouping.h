// SPDX-License-Identifier: Apache-2.0
// Which moving pieces are parts of one thing. A person whose trunk stands still while head and arms move, or an animal
// seen through leaves, comes as several pieces: they stay near each other and go the same way.
#pragma once

#include <opencv2/core.hpp>

#include <utility>
#include <vector>

#include "geometry/moving/pieces.h"

namespace uwv::moving {

/// What one frame's pieces have to do with each other and with those of the next.
struct PieceRelations {
  std::vector<int> becomes;                 ///< Of each piece: the next frame's piece it turns into, or -1.
  std::vector<cv::Vec2f> steps;             ///< Of each piece: mean flow to the next frame, in picture heights.
  std::vector<std::pair<int, int>> nearby;  ///< Pairs of this frame's pieces a small gap apart, lower index first.
};

/// `flow` (CV_32FC2, to the next frame) may be smaller than the labels; empty in the last frame, where nothing is
/// followed.
PieceRelations relate_pieces(const std::vector<Piece>& pieces, const cv::Mat& labels, const cv::Mat& flow,
                             const std::vector<Piece>& next, const cv::Mat& next_labels);

/// The object each piece of each frame belongs to. Objects count from 0 in the order in which they appear; an object
/// lives in consecutive frames.
std::vector<std::vector<int>> group_pieces(const std::vector<std::size_t>& pieces_of_frame,
                                           const std::vector<PieceRelations>& relations);

}  // namespace uwv::moving
