// SPDX-License-Identifier: Apache-2.0
// What lies behind the foreground of the planar prior: ground, backdrop, sky.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "geometry/layers/cv_bridge.h"
#include "geometry/layers/prior_parts.h"

namespace uwv::layers {
namespace {

constexpr float backdrop_confidence = 0.2F, sky_confidence = 0.1F;

/// Mean Lab colour and roughness of every row's background; rows without any have weight 0.
struct RowLook {
  cv::Vec4d sum;
  double weight = 0;
};
std::vector<RowLook> look_at_rows(const ImageRgb& picture, const ForegroundMask& foreground) {
  cv::Mat colour, lab;
  view(picture).convertTo(colour, CV_32F);
  cv::cvtColor(colour / 255, lab, cv::COLOR_RGB2Lab);
  const cv::Mat rough = roughness(colour);
  std::vector<RowLook> rows(static_cast<std::size_t>(picture.height()));
  for (int y = 0; y < picture.height(); ++y) {
    RowLook& row = rows[static_cast<std::size_t>(y)];
    for (int x = 0; x < picture.width(); ++x) {
      if (!foreground.empty() && foreground(x, y) != 0) continue;
      const cv::Vec3f v = lab.at<cv::Vec3f>(y, x);
      row.sum += cv::Vec4d(v[0], v[1], v[2], 0.3 * static_cast<double>(rough.at<float>(y, x)));
      row.weight += 1;
    }
  }
  return rows;
}

double squared(const cv::Vec4d& v) { return v.dot(v); }

}  // namespace

cv::Mat roughness(const cv::Mat& colour) {
  cv::Mat mean, mean_of_squares, deviation;
  cv::blur(colour, mean, {7, 7});
  cv::blur(colour.mul(colour), mean_of_squares, {7, 7});
  cv::sqrt(cv::max(mean_of_squares - mean.mul(mean), 0), deviation);
  std::array<cv::Mat, 3> channels;
  cv::split(deviation, channels.data());
  return cv::max(channels[0], cv::max(channels[1], channels[2]));
}

double Layout::horizon_row() const { return intrinsics.cy - intrinsics.fy * std::tan(pitch); }

double Layout::ground_depth(double v) const {
  const double slope = (v - intrinsics.cy) / intrinsics.fy;
  const double down = slope * std::cos(pitch) + std::sin(pitch);
  return down > 1e-9 ? camera_height / down : 0;
}

double Layout::wall_depth(double v, double distance) const {
  const double slope = (v - intrinsics.cy) / intrinsics.fy;
  const double forward = std::cos(pitch) - slope * std::sin(pitch);
  return distance / std::clamp(forward, 0.05, 20.0);
}

double Layout::ground_distance(double v) const {
  const double depth = ground_depth(v);
  if (!(depth > 0)) return std::numeric_limits<double>::infinity();
  const double slope = (v - intrinsics.cy) / intrinsics.fy;
  return depth * (std::cos(pitch) - slope * std::sin(pitch));
}

double Layout::ground_row(double distance) const {
  return intrinsics.cy + intrinsics.fy * std::tan(std::atan(camera_height / distance) - pitch);
}

std::optional<double> ground_end(const ImageRgb& picture, const ForegroundMask& foreground, double horizon_row) {
  const int height = picture.height();
  const int first = std::max(0, static_cast<int>(std::floor(horizon_row - 0.1 * height)));
  const int from = std::max(first + 2, static_cast<int>(std::ceil(horizon_row + 0.03 * height)));
  const int to = static_cast<int>(0.92 * height);
  if (to - from < 8) return std::nullopt;
  const std::vector<RowLook> rows = look_at_rows(picture, foreground);
  RowLook all;
  for (int y = first; y < height; ++y) {
    all.sum += rows[static_cast<std::size_t>(y)].sum;
    all.weight += rows[static_cast<std::size_t>(y)].weight;
  }
  if (!(all.weight > 0)) return std::nullopt;
  double spread = 0;
  for (int y = first; y < height; ++y) {
    const RowLook& row = rows[static_cast<std::size_t>(y)];
    if (row.weight > 0) spread += row.weight * squared(row.sum / row.weight - all.sum / all.weight);
  }
  // Otsu's split of the rows: the variance between what is above and what is below, as a share of all of it.
  RowLook above;
  double best = 0, distance = 0;
  int end = 0;
  for (int y = first; y < to; ++y) {
    above.sum += rows[static_cast<std::size_t>(y)].sum;
    above.weight += rows[static_cast<std::size_t>(y)].weight;
    const double below = all.weight - above.weight;
    if (y < from || !(above.weight > 0) || !(below > 0)) continue;
    const cv::Vec4d step = above.sum / above.weight - (all.sum - above.sum) / below;
    const double between = above.weight * below / all.weight * squared(step);
    if (between <= best) continue;
    best = between;
    distance = std::sqrt(squared(step));
    end = y + 1;
  }
  if (best < 0.6 * spread || distance < 8) return std::nullopt;
  return end;
}

ImageRgb backdrop_picture(std::span<const ImageRgb> frames, std::span<const ForegroundMask> foreground, int samples,
                          ForegroundMask& always) {
  const std::size_t count = std::min(frames.size(), static_cast<std::size_t>(samples));
  const Size size = frames.front().size();
  ImageRgb out(size);
  always = ForegroundMask(size);
  std::array<std::vector<std::uint8_t>, 3> seen;
  const auto gather = [&](std::size_t pixel, bool everything) {
    for (auto& channel : seen) channel.clear();
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t frame = i * frames.size() / count;
      if (!everything && !foreground.empty() && foreground[frame].data()[pixel] != 0) continue;
      const Rgb8 colour = frames[frame].data()[pixel];
      seen[0].push_back(colour.r);
      seen[1].push_back(colour.g);
      seen[2].push_back(colour.b);
    }
    return !seen[0].empty();
  };
  const auto median = [](std::vector<std::uint8_t>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  for (std::size_t pixel = 0; pixel < size.pixels(); ++pixel) {
    if (!gather(pixel, false)) {
      always.data()[pixel] = 1;
      gather(pixel, true);
    }
    out.data()[pixel] = {median(seen[0]), median(seen[1]), median(seen[2])};
  }
  return out;
}

FrameGeometry backdrop_geometry(const Layout& layout, const std::vector<double>& contour,
                                const Image<std::uint8_t>& sky, double sky_distance) {
  FrameGeometry out{DepthMap(sky.size()), ConfidenceMap(sky.size())};
  const double farthest = layout.backdrop_distance;
  std::vector<double> wall(static_cast<std::size_t>(sky.width()), farthest);  // level distance of every column's
  for (std::size_t x = 0; x < contour.size(); ++x) wall[x] = std::min(farthest, layout.ground_distance(contour[x]));
  for (int y = 0; y < sky.height(); ++y) {
    const double v = y + 0.5, ground = layout.ground_depth(v), ground_distance = layout.ground_distance(v);
    const double depth_of_distance = layout.wall_depth(v, 1);
    for (int x = 0; x < sky.width(); ++x) {
      const double standing = wall[static_cast<std::size_t>(x)];
      const bool on_ground = ground_distance < standing, is_sky = sky(x, y) != 0 && !on_ground;
      const double distance = is_sky ? farthest * sky_distance : standing;
      out.depth(x, y) = static_cast<float>(on_ground ? ground : distance * depth_of_distance);
      out.confidence(x, y) = is_sky ? sky_confidence : on_ground ? ground_confidence : backdrop_confidence;
    }
  }
  return out;
}

}  // namespace uwv::layers
