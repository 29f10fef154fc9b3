// SPDX-License-Identifier: Apache-2.0
#include "geometry/mvs/view.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace uwv::mvs {
namespace {

/// Without points, scenes are taken to be this many times as deep as the cameras are apart: about 5 degrees of angle.
constexpr double guessed_depth_per_baseline = 12;

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<double> depths_of_points(std::span<const Camera> cameras, std::span<const ScenePoint> points) {
  std::vector<double> depths;
  // A few cameras spread over the clip tell as much as all of them.
  const std::size_t stride = std::max<std::size_t>(1, cameras.size() / 8);
  for (std::size_t i = 0; i < cameras.size(); i += stride) {
    const Rigid3& pose = cameras[i].world_from_cam;
    for (const ScenePoint& point : points) {
      const double z = (pose.rotation.transpose() * (point.x_in_world - pose.translation)).z();
      if (std::isfinite(z) && z > 0) depths.push_back(z);
    }
  }
  return depths;
}

Image<float> grey_of(const ImageRgb& frame) {
  Image<float> grey(frame.size());
  const Rgb8* from = frame.data();
  float* to = grey.data();
  for (std::size_t i = 0; i < frame.size().pixels(); ++i)
    to[i] = 0.299F * static_cast<float>(from[i].r) + 0.587F * static_cast<float>(from[i].g) +
            0.114F * static_cast<float>(from[i].b) - 128.0F;
  return grey;
}

Image<float> shrink(const Image<float>& picture, Size size) {
  if (picture.size() == size) return picture;
  Image<float> out(size);
  const cv::Mat from(picture.height(), picture.width(), CV_32FC1, const_cast<float*>(picture.data()));
  cv::Mat to(size.height, size.width, CV_32FC1, out.data());
  cv::resize(from, to, to.size(), 0, 0, cv::INTER_AREA);
  return out;
}

}  // namespace

Camera Normalisation::apply(const Camera& camera) const {
  Camera out = camera;
  out.world_from_cam.translation = apply(camera.world_from_cam.translation);
  return out;
}

Normalisation find_normalisation(std::span<const Camera> cameras, std::span<const ScenePoint> points) {
  Normalisation out;
  if (cameras.empty()) return out;
  out.centre = cameras.front().world_from_cam.translation;
  std::vector<double> depths = depths_of_points(cameras, points);
  if (!depths.empty()) {
    out.unit = median(depths);
    return out;
  }
  std::vector<double> distances;
  const std::size_t step = std::min<std::size_t>(4, cameras.size() - 1);
  for (std::size_t i = 0; i + step < cameras.size(); ++i)
    distances.push_back((cameras[i + step].world_from_cam.translation - cameras[i].world_from_cam.translation).norm());
  const double distance = median(distances);
  if (std::isfinite(distance) && distance > 0) out.unit = guessed_depth_per_baseline * distance;
  return out;
}

ImageRgb shrink(const ImageRgb& picture, Size size) {
  if (picture.size() == size) return picture;
  ImageRgb out(size);
  const cv::Mat from(picture.height(), picture.width(), CV_8UC3, const_cast<Rgb8*>(picture.data()));
  cv::Mat to(size.height, size.width, CV_8UC3, out.data());
  cv::resize(from, to, to.size(), 0, 0, cv::INTER_AREA);
  return out;
}

View make_view(const ImageRgb& frame, const Camera& normalised, const ValidityMask* usable, Size size) {
  View view;
  view.camera = normalised;
  view.camera.intrinsics = normalised.intrinsics.resized(frame.size(), size);
  view.camera.size = size;
  view.grey = shrink(grey_of(frame), size);
  view.colour = shrink(frame, size);
  if (usable == nullptr || usable->empty()) return view;
  // A shrunken pixel is usable when all it was made of is.
  Image<std::uint8_t> small(size, 1);
  const double fx = static_cast<double>(size.width) / frame.width();
  const double fy = static_cast<double>(size.height) / frame.height();
  for (int y = 0; y < frame.height(); ++y)
    for (int x = 0; x < frame.width(); ++x)
      if ((*usable)(x, y) == 0)
        small(std::min(static_cast<int>((x + 0.5) * fx), size.width - 1),
              std::min(static_cast<int>((y + 0.5) * fy), size.height - 1)) = 0;
  view.usable = std::move(small);
  return view;
}

}  // namespace uwv::mvs
