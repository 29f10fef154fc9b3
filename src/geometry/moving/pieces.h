// SPDX-License-Identifier: Apache-2.0
// Connected moving pieces of each frame: where they stand, what is behind them, and which belong together over time.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include <span>
#include <vector>

#include "uwv/core/camera.h"
#include "uwv/core/mask.h"
#include "uwv/geometry/moving_objects.h"

namespace uwv::moving {

/// One connected moving piece in one frame.
struct Piece {
  int label = 0;  ///< In the picture of labels of its frame.
  cv::Rect box;
  int area = 0;
  bool cut_sideways = false, cut_upright = false;  ///< By the picture's border.
  Eigen::Vector2d foot = Eigen::Vector2d::Zero();  ///< Its lowest place, pixels.
  double contact = 0;  ///< Inverse depth at the foot of the plane it seems to touch; 0 = none is seen.
  Eigen::Vector3d normal_in_cam = Eigen::Vector3d::Zero();  ///< Of that plane, towards the camera.
  std::vector<float> behind;  ///< Per row of the box: inverse depth of the static scene beside it; 0 = unknown.
  double behind_median = 0;   ///< Of the known ones; 0 = none.
};

/// A frame's pieces; `labels` (CV_32S, 0 = static) comes out too.
std::vector<Piece> find_pieces(const ValidityMask& static_pixels, cv::Mat& labels);

/// The same with the pieces of one object made one: piece i becomes part of object objects[i]. The labels become 1 +
/// the index in the result, whose order is that of the objects. `numbers` (same order) tells which objects they are.
/// The foot is the lowest one of the larger parts.
std::vector<Piece> join_pieces(const std::vector<Piece>& pieces, const std::vector<int>& objects, cv::Mat& labels,
                               std::vector<int>& numbers);

/// Fills in contact, normal_in_cam and behind from the depth of the static scene.
void measure_piece(Piece& piece, const cv::Mat& labels, const DepthMap& depth, const Intrinsics& intrinsics,
                   const MovingDepthOptions& options);

/// For each piece of one frame the index of the piece of the next that it becomes, or -1. `flow` (CV_32FC2) may be
/// smaller than the labels.
std::vector<int> follow_pieces(const std::vector<Piece>& from, const cv::Mat& from_labels, const cv::Mat& flow,
                               const std::vector<Piece>& to, const cv::Mat& to_labels);

/// How many times larger `piece` appears than `reference`: by area, which a swinging arm changes least, where both are
/// whole; else from whichever extent the border cuts in neither; 1 when both are cut.
double size_ratio(const Piece& piece, const Piece& reference);

/// Where a piece stands: inverse depth at its foot, and which way is up there.
struct Stand {
  double at_foot = 0;
  Eigen::Vector3d up_in_cam = Eigen::Vector3d::Zero();
  float confidence = 0;
};

/// Writes depth and confidence of a piece standing upright there.
void paint_piece(const Piece& piece, const cv::Mat& labels, const Stand& stand, const Intrinsics& intrinsics,
                 const MovingDepthOptions& options, FrameGeometry& geometry);

}  // namespace uwv::moving
