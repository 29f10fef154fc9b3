// SPDX-License-Identifier: Apache-2.0
#include "geometry/moving/dense_flow.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace uwv::moving {

Size shrunk_size(Size size, int height) {
  if (size.height <= height) return size;
  const double scale = static_cast<double>(height) / size.height;
  return {std::max(1, static_cast<int>(std::lround(size.width * scale))), height};
}

cv::Mat shrunk_colour(const ImageRgb& picture, Size size) {
  const cv::Mat rgb(picture.height(), picture.width(), CV_8UC3, const_cast<Rgb8*>(picture.data()));
  cv::Mat small;
  cv::resize(rgb, small, cv::Size(size.width, size.height), 0, 0, cv::INTER_AREA);
  return small;
}

cv::Mat shrunk_grey(const ImageRgb& picture, Size size) {
  cv::Mat grey;
  cv::cvtColor(shrunk_colour(picture, size), grey, cv::COLOR_RGB2GRAY);
  return grey;
}

cv::Mat dense_flow(const cv::Mat& from, const cv::Mat& to) {
  cv::Mat flow = cv::Mat::zeros(from.size(), CV_32FC2);
  // Its patches are 8 pixels wide, and its pyramid ends where they no longer fit in.
  if (std::min(from.rows, from.cols) < 32) return flow;
  const auto search = cv::DISOpticalFlow::create(cv::DISOpticalFlow::PRESET_MEDIUM);
  search->calc(from, to, flow);
  return flow;
}

cv::Mat round_trip_error(const cv::Mat& there, const cv::Mat& back) {
  cv::Mat error(there.size(), CV_32F);
  for (int y = 0; y < there.rows; ++y)
    for (int x = 0; x < there.cols; ++x) {
      const cv::Vec2f step = there.at<cv::Vec2f>(y, x);
      const float u = static_cast<float>(x) + step[0], v = static_cast<float>(y) + step[1];
      float& e = error.at<float>(y, x);
      e = 1e6F;
      if (!(u >= 0 && v >= 0 && u <= static_cast<float>(there.cols - 1) && v <= static_cast<float>(there.rows - 1)))
        continue;
      const int x0 = std::min(static_cast<int>(u), std::max(0, there.cols - 2));
      const int y0 = std::min(static_cast<int>(v), std::max(0, there.rows - 2));
      const int x1 = std::min(x0 + 1, there.cols - 1), y1 = std::min(y0 + 1, there.rows - 1);
      const float a = u - static_cast<float>(x0), b = v - static_cast<float>(y0);
      const cv::Vec2f upper = back.at<cv::Vec2f>(y0, x0) * (1 - a) + back.at<cv::Vec2f>(y0, x1) * a;
      const cv::Vec2f lower = back.at<cv::Vec2f>(y1, x0) * (1 - a) + back.at<cv::Vec2f>(y1, x1) * a;
      const cv::Vec2f loop = step + upper * (1 - b) + lower * b;
      e = std::hypot(loop[0], loop[1]);
    }
  return error;
}

}  // namespace uwv::moving
