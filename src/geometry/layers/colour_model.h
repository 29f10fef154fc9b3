// SPDX-License-Identifier: Apache-2.0
// Which colours speak for the foreground and which for its surroundings.
#pragma once

#include <opencv2/core.hpp>

#include <vector>

namespace uwv::layers {

/// Two smoothed histograms of 16 levels a channel.
class ColourModel {
 public:
  ColourModel();
  /// Takes in a picture (CV_8UC3): `mask` (CV_8U) is foreground, what lies within `reach` pixels around it is
  /// surroundings. Older colours keep the weight 1 - rate.
  void learn(const cv::Mat& picture, const cv::Mat& mask, int reach, double rate);
  /// Logarithm of foreground's odds by colour, within [-3, 3]; 0 where neither has been seen.
  float log_odds(const cv::Vec3b& colour) const;

 private:
  std::vector<float> foreground_, surroundings_, odds_;
};

}  // namespace uwv::layers
