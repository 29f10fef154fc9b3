// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/depth_composite.h"

#include <opencv2/imgproc.hpp>

namespace uwv {
namespace {

void check_window(int window, int iterations) {
  require(window >= 1 && window <= 255 && window % 2 == 1, "a mask window of {} is not an odd number in 1..255",
          window);
  require(iterations >= 0 && iterations <= 1000, "{} mask iterations are not in 0..1000", iterations);
}

enum class Morph { grow, shrink };

ForegroundMask morphed(const ForegroundMask& mask, int window, int iterations, Morph morph) {
  check_window(window, iterations);
  if (mask.empty() || iterations == 0 || window == 1) return mask;
  ForegroundMask out(mask.size());
  // OpenCV never writes to the source; its matrices just cannot say so.
  const cv::Mat from(mask.height(), mask.width(), CV_8U, const_cast<std::uint8_t*>(mask.data()));
  cv::Mat to(out.height(), out.width(), CV_8U, out.data());
  const cv::Mat square = cv::Mat::ones(window, window, CV_8U);
  if (morph == Morph::grow)
    cv::dilate(from, to, square, cv::Point(-1, -1), iterations);
  else
    cv::erode(from, to, square, cv::Point(-1, -1), iterations);
  return out;
}

}  // namespace

void CompositeOptions::check() const {
  check_window(ring_window, ring_iterations);
  check_window(close_window, close_iterations);
}

ForegroundMask dilate_mask(const ForegroundMask& mask, int window, int iterations) {
  return morphed(mask, window, iterations, Morph::grow);
}

ForegroundMask erode_mask(const ForegroundMask& mask, int window, int iterations) {
  return morphed(mask, window, iterations, Morph::shrink);
}

ForegroundMask close_mask(const ForegroundMask& mask, int window, int iterations) {
  return erode_mask(dilate_mask(mask, window, iterations), window, iterations);
}

DepthMap composite_depth(const DepthMap& foreground_depth, const DepthMap& background_depth,
                         const ForegroundMask& foreground, const CompositeOptions& options) {
  options.check();
  require(foreground_depth.size() == foreground.size() && background_depth.size() == foreground.size(),
          "foreground depth is {}x{}, background depth {}x{}, their mask {}x{} pixels", foreground_depth.width(),
          foreground_depth.height(), background_depth.width(), background_depth.height(), foreground.width(),
          foreground.height());
  const ForegroundMask inner = close_mask(foreground, options.close_window, options.close_iterations);
  const ForegroundMask outer = options.ring ? dilate_mask(inner, options.ring_window, options.ring_iterations) : inner;
  DepthMap out(foreground.size());
  for (std::size_t p = 0; p < out.pixels().size(); ++p) {
    if (inner.pixels()[p] != 0)
      out.pixels()[p] = foreground_depth.pixels()[p];
    else if (outer.pixels()[p] == 0)
      out.pixels()[p] = background_depth.pixels()[p];
  }
  return out;
}

}  // namespace uwv
