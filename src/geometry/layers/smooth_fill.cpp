// SPDX-License-Identifier: Apache-2.0
#include "geometry/layers/smooth_fill.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "uwv/core/depth.h"

namespace uwv::layers {
namespace {

constexpr int sweeps = 60;  // per level; the level above has removed the slow errors
constexpr float over_relaxation = 1.8F;

enum State : std::uint8_t { outside, open, known };

/// Inverse depths of one resolution and what is known of them.
struct Level {
  cv::Mat_<float> value;
  cv::Mat_<std::uint8_t> state;
};

Level finest(const DepthMap& depth, const cv::Mat& missing, const cv::Rect& box) {
  Level level{cv::Mat_<float>(box.size(), 0.0F), cv::Mat_<std::uint8_t>(box.size(), outside)};
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x) {
      const float z = depth(box.x + x, box.y + y);
      if (missing.at<std::uint8_t>(box.y + y, box.x + x) != 0)
        level.state(y, x) = open;
      else if (is_valid_depth(z))
        level.state(y, x) = known, level.value(y, x) = 1 / z;
    }
  return level;
}

/// Half the size: the mean of what is known; open where nothing is, but something is open.
Level coarser(const Level& fine) {
  const cv::Size size((fine.value.cols + 1) / 2, (fine.value.rows + 1) / 2);
  Level out{cv::Mat_<float>(size, 0.0F), cv::Mat_<std::uint8_t>(size, outside)};
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      float sum = 0, count = 0;
      bool any_open = false;
      for (int v = 2 * y; v < std::min(2 * y + 2, fine.value.rows); ++v)
        for (int u = 2 * x; u < std::min(2 * x + 2, fine.value.cols); ++u) {
          any_open = any_open || fine.state(v, u) == open;
          if (fine.state(v, u) == known) sum += fine.value(v, u), count += 1;
        }
      out.state(y, x) = count > 0 ? known : any_open ? open : outside;
      out.value(y, x) = count > 0 ? sum / count : 0;
    }
  return out;
}

bool has(const Level& level, State state) { return cv::countNonZero(level.state == state) > 0; }

void start_from(const Level& coarse, Level& fine) {
  for (int y = 0; y < fine.value.rows; ++y)
    for (int x = 0; x < fine.value.cols; ++x)
      if (fine.state(y, x) == open) fine.value(y, x) = coarse.value(y / 2, x / 2);
}

/// Every open pixel becomes the mean of its neighbours, again and again.
void relax(Level& level) {
  std::vector<cv::Point> points;
  cv::findNonZero(level.state == open, points);
  constexpr int steps[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (const cv::Point& p : points) {
      float sum = 0, count = 0;
      for (const auto& step : steps) {
        const int x = p.x + step[0], y = p.y + step[1];
        if (x < 0 || y < 0 || x >= level.value.cols || y >= level.value.rows || level.state(y, x) == outside ||
            !(level.value(y, x) > 0))
          continue;
        sum += level.value(y, x), count += 1;
      }
      if (!(count > 0)) continue;
      float& own = level.value(p);
      own = own > 0 ? std::max(0.0F, own + over_relaxation * (sum / count - own)) : sum / count;
    }
}

void solve(Level& level) {
  if (!has(level, open) || !has(level, known)) return;
  if (std::max(level.value.cols, level.value.rows) > 2) {
    Level coarse = coarser(level);
    solve(coarse);
    start_from(coarse, level);
  }
  relax(level);
}

}  // namespace

void fill_smoothly(DepthMap& depth, const cv::Mat& missing) {
  cv::Rect box = cv::boundingRect(missing);
  if (box.area() == 0) return;
  box = cv::Rect(box.x - 1, box.y - 1, box.width + 2, box.height + 2) & cv::Rect(0, 0, depth.width(), depth.height());
  Level level = finest(depth, missing, box);
  solve(level);
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x)
      if (level.state(y, x) == open) {
        const float z = level.value(y, x) > 0 ? 1 / level.value(y, x) : 0.0F;
        depth(box.x + x, box.y + y) = is_valid_depth(z) ? z : 0.0F;
      }
}

}  // namespace uwv::layers
