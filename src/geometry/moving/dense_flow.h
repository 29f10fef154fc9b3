// SPDX-License-Identifier: Apache-2.0
// Dense optical flow between frames of a clip, the same on every number of threads.
#pragma once

#include <opencv2/core.hpp>

#include <span>
#include <vector>

#include "uwv/core/image.h"

namespace uwv::moving {

/// The size at most `height` rows tall that keeps the shape of `size`; at least 1 x 1.
Size shrunk_size(Size size, int height);

/// The picture in the given size, CV_8UC3.
cv::Mat shrunk_colour(const ImageRgb& picture, Size size);

/// Grey, 8 bits, of the given size.
cv::Mat shrunk_grey(const ImageRgb& picture, Size size);

/// Flow (CV_32FC2, pixels) from each pixel of `from` to `to`. Pictures too small for flow give zeros.
cv::Mat dense_flow(const cv::Mat& from, const cv::Mat& to);

/// |there + back| per pixel (CV_32F): how far one ends from where one began; 1e6 where the flow leaves the picture.
cv::Mat round_trip_error(const cv::Mat& there, const cv::Mat& back);

}  // namespace uwv::moving
