// SPDX-License-Identifier: Apache-2.0
// What other frames know of places that one frame cannot see.
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <vector>

#include "uwv/core/camera.h"
#include "uwv/core/image.h"

namespace uwv::layers {

/// Of a frame's pixels, what they are worth for other frames.
enum Worth : std::uint8_t { nothing = 0, guessed = 1, measured = 2 };

/// A frame with its camera, its depth and what each pixel is worth (CV_8U, Worth): nothing where it moves, guessed
/// where its depth was filled in. Parts of moving things that were not found have depth that was filled in.
struct StaticView {
  const ImageRgb* colour;
  const DepthMap* depth;
  const Camera* camera;
  cv::Mat worth;
};

/// For each pixel of `box`, inverse depth of the nearest static point that lands there; 0 = none.
struct DepthSighting {
  cv::Mat_<float> by_measured, by_guessed;
};
DepthSighting splat_depth(const StaticView& from, const Camera& to, const cv::Rect& box);

/// Of inverse depths seen by several views (reordered), that of the nearest surface that enough of them agree on; 0
/// when there are none.
float agreed_surface(std::vector<float>& inverse_depths, double tolerance);

/// Looks a point up in another view.
class ViewLookup {
 public:
  /// `tolerance`: relative difference of depth up to which it is the same surface.
  ViewLookup(const Camera& own, const StaticView& other, double tolerance);
  /// The colour (0..255) of the point seen at `pixel` of the own frame with depth z; false where the other view does
  /// not see that surface.
  Worth colour(const Eigen::Vector2d& pixel, double z, cv::Vec3f& out) const;

 private:
  const StaticView& other_;
  Eigen::Matrix3d rotate_;
  Eigen::Vector3d shift_;
  double tolerance_;
};

/// Factor by channel that makes the view looked up in as bright as `own`, by points that both see; ones where these are
/// few.
std::array<float, 3> view_gain(const StaticView& own, const ViewLookup& lookup);

}  // namespace uwv::layers
