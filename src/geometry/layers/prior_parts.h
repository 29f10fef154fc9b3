// SPDX-License-Identifier: Apache-2.0
// The parts of the planar prior: what is read from the picture, and what is built from it.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "uwv/geometry/planar_prior.h"

namespace uwv::layers {

constexpr float ground_confidence = 0.3F;  ///< The greatest of a prior; walls and sky have less.

/// A level ground and an upright wall, seen by a camera that looks down by `pitch`.
struct Layout {
  Intrinsics intrinsics;
  double pitch = 0;
  double camera_height = 1;
  double backdrop_distance = 1;  ///< Level, forward.

  double horizon_row() const;
  /// Depth of the ground at row v (pixel units, centres at +0.5); 0 at and above the horizon.
  double ground_depth(double v) const;
  /// Depth of an upright wall at level distance `distance`, held within [0.05, 20] times it.
  double wall_depth(double v, double distance) const;
  /// Level distance of the ground seen at row v; infinite at and above the horizon.
  double ground_distance(double v) const;
  /// Row at which the ground at a level distance is seen.
  double ground_row(double distance) const;
};

/// Row of the horizon by the vanishing point that most oblique lines agree on; empty when too few do.
std::optional<double> horizon_from_lines(const ImageRgb& picture);

/// Standard deviation in a window of 7, the largest of the three channels of a float picture: sky is smooth where
/// leaves are not.
cv::Mat roughness(const cv::Mat& colour);

/// 1 = sky: smooth, pale or blue, joined to the upper edge, and brighter than the rest of the picture. All 0 when the
/// evidence is not believed. `foreground` may be empty.
Image<std::uint8_t> find_sky(const ImageRgb& picture, const ForegroundMask& foreground, SkyEvidence& evidence);

/// Lower end of a sky that ends level enough to be the horizon.
std::optional<double> horizon_from_sky(const Image<std::uint8_t>& sky);

/// Row, in (horizon, height), at which the colour of whole rows changes most; empty when none stands out.
std::optional<double> ground_end(const ImageRgb& picture, const ForegroundMask& foreground, double horizon_row);

/// The contour that divides colours of the ground from those of what stands on it, by dynamic programming over columns.
/// `start` is a first guess of its row, `highest` the least row it may have. Empty when the colours do not differ
/// enough to tell.
std::vector<double> find_contour(const ImageRgb& picture, const ForegroundMask& foreground,
                                 const Image<std::uint8_t>& sky, double horizon_row, double start, double highest);

/// What a locked-off camera sees behind its foreground: the median of what was not foreground in up to `samples`
/// frames, of everything where it always was. `always` says where that is.
ImageRgb backdrop_picture(std::span<const ImageRgb> frames, std::span<const ForegroundMask> foreground, int samples,
                          ForegroundMask& always);

/// Ground, backdrop and sky of one picture. What is narrow stands before the wall up to the horizon, which is as high
/// as the camera.
FrameGeometry backdrop_geometry(const Layout& layout, const std::vector<double>& contour,
                                const Image<std::uint8_t>& sky, double sky_distance);

/// A connected piece of foreground in one frame.
struct Piece {
  int first_row = 0, last_row = 0;  ///< Inclusive.
  std::size_t pixels = 0;
  int track = -1;      ///< The same from frame to frame.
  double contact = 0;  ///< Row at which it touches the ground, steadied in time.
};
/// The pieces of one frame; labels are 0 for background, else 1 + index of the piece.
struct Pieces {
  Image<std::int32_t> labels;
  std::vector<Piece> pieces;
};
/// Connected pieces of at least min_pixels; smaller ones take the label of the nearest larger one, and are dropped when
/// there is none and the whole mask is smaller.
Pieces find_pieces(const ForegroundMask& mask, std::size_t min_pixels);
/// Gives pieces of neighbouring frames that overlap the same track, and every piece its steadied contact row.
void track_contacts(std::vector<Pieces>& frames, int window);
/// Sets the foreground upright into a frame that holds the backdrop.
void place_pieces(const Pieces& pieces, const Layout& layout, const PlanarPriorOptions& options, FrameGeometry& frame);

}  // namespace uwv::layers
