// SPDX-License-Identifier: Apache-2.0
// How strongly flow between two frames contradicts a static scene, pixel by pixel.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include <vector>

#include "uwv/core/camera.h"
#include "uwv/geometry/moving_objects.h"

namespace uwv::moving {

/// Inverse depths a pixel can have if it is static. {0, infinity} = anything.
struct InverseRange {
  float low = 0, high = 0;
};

/// Where static points of one camera's picture land in another's: m0 + w * m1 for inverse depth w.
class StaticMotion {
 public:
  StaticMotion(const Camera& from, const Camera& to);
  /// Distance in pixels from `landed` to where a static point seen at `pixel` can land, for inverse depths in `range`;
  /// negative when it cannot be seen from there at all. `inverse_depth`: of the nearest possible place.
  double distance(const Eigen::Vector2d& pixel, const Eigen::Vector2d& landed, const InverseRange& range,
                  double& inverse_depth) const;
  /// The two ends of where a static point seen at `pixel` can land; false when it cannot be seen from there at all.
  bool ends(const Eigen::Vector2d& pixel, const InverseRange& range, Eigen::Vector2d& start,
            Eigen::Vector2d& end) const;
  /// Length in pixels of the shift that comes with inverse depth w, roughly.
  double parallax(double inverse_depth) const { return inverse_depth * per_inverse_depth_; }

 private:
  struct Segment {
    Eigen::Vector3d start, end;  ///< Homogeneous.
    double low, high;            ///< Inverse depths there.
  };
  bool segment(const Eigen::Vector2d& pixel, const InverseRange& range, Segment& out) const;

  Eigen::Matrix3d infinite_;  ///< The homography of infinitely far points.
  Eigen::Vector3d epipole_;   ///< Homogeneous; its length carries the baseline.
  double per_inverse_depth_;
  double longest_px_;  ///< No static thing is assumed to shift farther than this from where it would be infinitely far.
};

/// Flow from one frame to another with what it needs to be judged.
struct FlowPair {
  cv::Mat flow, round_trip;
};

/// Mean squared grey gradient around each pixel (CV_32F); flow on blank areas is a guess.
cv::Mat texture_energy(const cv::Mat& grey);

/// One of the two frames that are compared, and what is known of it.
struct JudgedFrame {
  const cv::Mat &grey, &texture;
  const std::vector<InverseRange>& ranges;  ///< Row-major, one per pixel.
};

/// Evidence of motion, 1 = as significant as asked for; 0 = static. All CV_32F.
struct Evidence {
  explicit Evidence(Size size);
  cv::Mat sum, count;                  ///< Of everything that could be judged.
  cv::Mat certain_sum, certain_count;  ///< Of what good flow says, and of what looks static.
};

/// Adds one pair's evidence: distance over uncertainty (capped) where flow can be trusted. A pixel whose surroundings
/// look in the other frame as they should if they were static is static, whatever flow says: flow bleeds over outlines
/// and errs on repeating patterns. Where flow cannot be trusted, a pixel that looks static nowhere may be moving and
/// turning, or covered: that counts nearly as much, but not as certain.
void add_evidence(const StaticMotion& motion, const FlowPair& pair, const JudgedFrame& from, const cv::Mat& to_grey,
                  const MovingOptions& options, Evidence& evidence);

/// Mean evidence per pixel, of the direction in time with less of it: what is covered or uncovered contradicts one
/// direction only. Where one direction is all there is, only what is certain counts. Pixels that could not be judged
/// take the mean around them.
cv::Mat combine_evidence(const Evidence& ahead, const Evidence& back);

/// Inverse depths by triangulating well-behaved flow, on a grid; appended to `found` when they mean something.
void collect_inverse_depths(const StaticMotion& motion, const FlowPair& pair, const cv::Mat& texture,
                            std::vector<float>& found);

}  // namespace uwv::moving
