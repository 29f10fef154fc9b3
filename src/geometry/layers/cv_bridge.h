// SPDX-License-Identifier: Apache-2.0
// Our pictures as OpenCV's, without copying.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "uwv/core/image.h"

namespace uwv::layers {

/// Views share the picture's memory. OpenCV has no const pictures: views of const ones are only read.
inline cv::Mat view(const Image<std::uint8_t>& picture) {
  return {picture.height(), picture.width(), CV_8UC1, const_cast<std::uint8_t*>(picture.data())};
}
inline cv::Mat view(const Image<float>& picture) {
  return {picture.height(), picture.width(), CV_32FC1, const_cast<float*>(picture.data())};
}
inline cv::Mat view(const ImageRgb& picture) {
  return {picture.height(), picture.width(), CV_8UC3, const_cast<Rgb8*>(picture.data())};
}

inline Size size_of(const cv::Mat& mat) { return {mat.cols, mat.rows}; }

}  // namespace uwv::layers
