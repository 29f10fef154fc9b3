// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/reliability.h"

#include <limits>
#include <opencv2/imgproc.hpp>

#include "uwv/core/depth.h"

namespace uwv {
namespace {

/// OpenCV's view of a picture's rows [from, to), without copying.
cv::Mat rows_of(const DepthMap& depth, int from, int to) {
  return cv::Mat(to - from, depth.width(), CV_32F, const_cast<float*>(depth.row(from)));
}

/// Largest or smallest value in the window around every pixel of rows [from, to); outside the picture does not count.
cv::Mat extreme(const DepthMap& depth, int from, int to, const ReliabilityOptions& options, bool largest) {
  const int r = options.window / 2;
  const int first = std::max(0, from - r);
  const cv::Mat around = rows_of(depth, first, std::min(depth.height(), to + r));
  const cv::Mat box = cv::Mat::ones(options.window, options.window, CV_8U);
  const double neutral = largest ? std::numeric_limits<double>::lowest() : std::numeric_limits<double>::max();
  cv::Mat result;
  if (largest)
    cv::dilate(around, result, box, {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar::all(neutral));
  else
    cv::erode(around, result, box, {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar::all(neutral));
  return result.rowRange(from - first, to - first);
}

/// Window mean; zeros outside the picture count only if asked.
cv::Mat mean(const DepthMap& depth, int from, int to, const ReliabilityOptions& options) {
  const int r = options.window / 2;
  const int first = std::max(0, from - r);
  const cv::Mat around = rows_of(depth, first, std::min(depth.height(), to + r));
  const cv::Size box(options.window, options.window);
  cv::Mat sum;
  cv::boxFilter(around, sum, CV_32F, box, {-1, -1}, false, cv::BORDER_CONSTANT | cv::BORDER_ISOLATED);
  sum = sum.rowRange(from - first, to - first);
  if (options.count_padding) return sum / static_cast<double>(box.area());
  cv::Mat count;
  cv::boxFilter(cv::Mat::ones(around.size(), CV_32F), count, CV_32F, box, {-1, -1}, false,
                cv::BORDER_CONSTANT | cv::BORDER_ISOLATED);
  return sum / count.rowRange(from - first, to - first);
}

}  // namespace

void ReliabilityOptions::check() const {
  require(window >= 1 && window <= 255 && window % 2 == 1, "reliability window {} is not an odd number in 1..255",
          window);
  require(ratio > 0, "reliability ratio {} is not positive", ratio);
}

ValidityMask reliable_depth(const DepthMap& depth, const ReliabilityOptions& options, ThreadPool& pool) {
  options.check();
  ValidityMask reliable(depth.size());
  if (depth.empty()) return reliable;
  pool.for_ranges(0, depth.height(), 32, [&](int from, int to) {
    if (!options.enabled) {
      for (int y = from; y < to; ++y)
        for (int x = 0; x < depth.width(); ++x) reliable(x, y) = depth(x, y) > 0;
      return;
    }
    const cv::Mat high = extreme(depth, from, to, options, true);
    const cv::Mat low = extreme(depth, from, to, options, false);
    const cv::Mat average = mean(depth, from, to, options);
    for (int y = from; y < to; ++y) {
      const float* z = depth.row(y);
      const float* top = high.ptr<float>(y - from);
      const float* bottom = low.ptr<float>(y - from);
      const float* middle = average.ptr<float>(y - from);
      std::uint8_t* out = reliable.row(y);
      for (int x = 0; x < depth.width(); ++x)
        out[x] = static_cast<std::uint8_t>(((top[x] - bottom[x]) / (middle[x] + 1e-6F) < options.ratio) & (z[x] > 0));
    }
  });
  return reliable;
}

}  // namespace uwv
