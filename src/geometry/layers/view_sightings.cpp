// SPDX-License-Identifier: Apache-2.0
#include "geometry/layers/view_sightings.h"

#include <algorithm>
#include <cmath>

#include "geometry/layers/cv_bridge.h"
#include "uwv/core/depth.h"

namespace uwv::layers {
namespace {

/// K_to * R * K_from^-1 and K_to * t: a pixel with depth z lands at rotate * (x, y, 1) * z + shift, homogeneous.
struct PixelMove {
  Eigen::Matrix3d rotate;
  Eigen::Vector3d shift;
  PixelMove(const Camera& from, const Camera& to) {
    const Rigid3 to_from_from = target_from_source(to, from);
    rotate = to.intrinsics.matrix() * to_from_from.rotation * from.intrinsics.inverse_matrix();
    shift = to.intrinsics.matrix() * to_from_from.translation;
  }
};

/// Where the camera comes closer points move apart: pixels between two that hold the same surface take their mean.
void close_pinholes(cv::Mat_<float>& inverse_depth) {
  constexpr float alike = 0.95F;
  const cv::Mat_<float> before = inverse_depth.clone();
  const auto between = [](float a, float b) { return std::min(a, b) > alike * std::max(a, b) ? 0.5F * (a + b) : 0.0F; };
  for (int y = 0; y < before.rows; ++y)
    for (int x = 0; x < before.cols; ++x) {
      if (before(y, x) > 0) continue;
      const bool inner_x = x > 0 && x + 1 < before.cols, inner_y = y > 0 && y + 1 < before.rows;
      const float across = inner_x ? between(before(y, x - 1), before(y, x + 1)) : 0.0F;
      const float along = inner_y ? between(before(y - 1, x), before(y + 1, x)) : 0.0F;
      inverse_depth(y, x) = across > 0 ? across : along;
    }
}

}  // namespace

DepthSighting splat_depth(const StaticView& from, const Camera& to, const cv::Rect& box) {
  const PixelMove move(*from.camera, to);
  const DepthMap& depth = *from.depth;
  DepthSighting out{cv::Mat_<float>(box.size(), 0.0F), cv::Mat_<float>(box.size(), 0.0F)};
  for (int y = 0; y < depth.height(); ++y) {
    const std::uint8_t* worth = from.worth.ptr<std::uint8_t>(y);
    Eigen::Vector3d ray = move.rotate * Eigen::Vector3d(0.5, y + 0.5, 1);
    for (int x = 0; x < depth.width(); ++x, ray += move.rotate.col(0)) {
      const float z = depth(x, y);
      if (worth[x] == nothing || !is_valid_depth(z)) continue;
      const Eigen::Vector3d landed = ray * static_cast<double>(z) + move.shift;
      if (!(landed.z() > 0)) continue;
      const double inverse = 1 / landed.z();
      const double u = landed.x() * inverse - box.x, v = landed.y() * inverse - box.y;
      if (!(u >= 0 && v >= 0 && u < box.width && v < box.height)) continue;
      cv::Mat_<float>& nearest = worth[x] == measured ? out.by_measured : out.by_guessed;
      float& there = nearest(static_cast<int>(v), static_cast<int>(u));
      there = std::max(there, static_cast<float>(inverse));
    }
  }
  close_pinholes(out.by_measured);
  close_pinholes(out.by_guessed);
  return out;
}

float agreed_surface(std::vector<float>& inverse_depths, double tolerance) {
  if (inverse_depths.empty()) return 0;
  std::sort(inverse_depths.begin(), inverse_depths.end(), std::greater<>());
  const std::size_t count = inverse_depths.size(), enough = std::min(count, std::max<std::size_t>(2, count / 3));
  const auto slack = static_cast<float>(1 - tolerance);
  for (std::size_t first = 0; first + enough <= count; ++first) {
    std::size_t last = first;
    while (last + 1 < count && inverse_depths[last + 1] >= inverse_depths[first] * slack) ++last;
    if (last - first + 1 >= enough) return inverse_depths[(first + last) / 2];
  }
  return inverse_depths[count / 2];
}

ViewLookup::ViewLookup(const Camera& own, const StaticView& other, double tolerance)
    : other_(other), tolerance_(tolerance) {
  const PixelMove move(own, *other.camera);
  rotate_ = move.rotate;
  shift_ = move.shift;
}

Worth ViewLookup::colour(const Eigen::Vector2d& pixel, double z, cv::Vec3f& out) const {
  const Eigen::Vector3d landed = rotate_ * pixel.homogeneous() * z + shift_;
  if (!(landed.z() > 0)) return nothing;
  const double u = landed.x() / landed.z() - 0.5, v = landed.y() / landed.z() - 0.5;
  const ImageRgb& colour = *other_.colour;
  if (!(u >= 0 && v >= 0 && u <= colour.width() - 1 && v <= colour.height() - 1)) return nothing;
  const int x0 = std::min(static_cast<int>(u), std::max(0, colour.width() - 2));
  const int y0 = std::min(static_cast<int>(v), std::max(0, colour.height() - 2));
  const int x1 = std::min(x0 + 1, colour.width() - 1), y1 = std::min(y0 + 1, colour.height() - 1);
  const double there = (*other_.depth)(static_cast<int>(u + 0.5), static_cast<int>(v + 0.5));
  if (!(std::abs(there - landed.z()) <= tolerance_ * landed.z())) return nothing;
  std::uint8_t worth = measured;
  for (const int y : {y0, y1})
    for (const int x : {x0, x1}) worth = std::min(worth, other_.worth.at<std::uint8_t>(y, x));
  if (worth == nothing) return nothing;
  const auto a = static_cast<float>(u - x0), b = static_cast<float>(v - y0);
  const cv::Mat pixels = view(colour);
  const cv::Vec3f upper =
      cv::Vec3f(pixels.at<cv::Vec3b>(y0, x0)) * (1 - a) + cv::Vec3f(pixels.at<cv::Vec3b>(y0, x1)) * a;
  const cv::Vec3f lower =
      cv::Vec3f(pixels.at<cv::Vec3b>(y1, x0)) * (1 - a) + cv::Vec3f(pixels.at<cv::Vec3b>(y1, x1)) * a;
  out = upper * (1 - b) + lower * b;
  return static_cast<Worth>(worth);
}

std::array<float, 3> view_gain(const StaticView& own, const ViewLookup& lookup) {
  constexpr int stride = 7, fewest = 50;
  cv::Vec3d here(0, 0, 0), there(0, 0, 0);
  int count = 0;
  for (int y = stride / 2; y < own.depth->height(); y += stride)
    for (int x = stride / 2; x < own.depth->width(); x += stride) {
      const float z = (*own.depth)(x, y);
      cv::Vec3f seen;
      if (own.worth.at<std::uint8_t>(y, x) == nothing || !is_valid_depth(z)) continue;
      if (lookup.colour({x + 0.5, y + 0.5}, z, seen) == nothing) continue;
      const Rgb8 colour = (*own.colour)(x, y);
      here += cv::Vec3d(colour.r, colour.g, colour.b);
      there += cv::Vec3d(seen);
      ++count;
    }
  if (count < fewest) return {1, 1, 1};
  std::array<float, 3> gain{};
  for (std::size_t c = 0; c < 3; ++c) {
    const int channel = static_cast<int>(c);
    gain[c] = static_cast<float>(std::clamp((here[channel] + count) / (there[channel] + count), 0.5, 2.0));
  }
  return gain;
}

}  // namespace uwv::layers
