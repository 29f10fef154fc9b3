// SPDX-License-Identifier: Apache-2.0
// Parts of background completion that are of use alone.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "uwv/geometry/background_completion.h"

namespace uwv::layers {

/// A frame's picture as CV_8UC3 view and where it shows background (CV_8U, 255 = background).
struct SeenFrame {
  cv::Mat picture, background;
};

/// Fills `missing` (CV_8U) of `picture` (CV_8UC3) from around it; grey where nothing is known at all.
void invent(cv::Mat& picture, const cv::Mat& missing, const CompletionOptions& options);

/// Factor by channel that makes `other` as bright as `own` where both show background; ones where they hardly overlap.
std::array<float, 3> exposure_gain(const SeenFrame& own, const cv::Mat& other, const cv::Mat& other_background);

/// The homography (CV_64F 3x3) that maps background of `from` to `to`, by tracked corners; the identity, and false,
/// when too few corners agree.
bool background_homography(const SeenFrame& from, const SeenFrame& to, cv::Mat& to_from);

}  // namespace uwv::layers
