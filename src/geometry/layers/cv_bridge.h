// SPDX-License-Identifier: Apache-2.0
// Our pictures as OpenCV's, without copying, and OpenCV made deterministic.
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

/// Some of OpenCV's algorithms (DIS flow above all) give results that depend on the number of its threads; and random
/// ones start from a generator per thread. While this lives, OpenCV uses the calling thread only, from a fixed seed.
class DeterministicCv {
 public:
  DeterministicCv() : threads_(cv::getNumThreads()) {
    cv::setNumThreads(1);
    cv::theRNG().state = 0x5eed;
  }
  ~DeterministicCv() { cv::setNumThreads(threads_); }
  DeterministicCv(const DeterministicCv&) = delete;
  DeterministicCv& operator=(const DeterministicCv&) = delete;

 private:
  int threads_;
};

}  // namespace uwv::layers
