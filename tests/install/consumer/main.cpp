// SPDX-License-Identifier: Apache-2.0
// Moves the camera and prints where a point of the source picture lands in the target picture.
#include <uwv/core/camera.h>

#include <cstdio>

int main() {
  uwv::Camera source;
  source.size = {640, 480};
  source.intrinsics = {500, 500, 320, 240};
  uwv::Camera target = source;
  target.world_from_cam.translation = {-0.4, 0, 0};

  const Eigen::Vector3d x_in_source = uwv::unproject(source.intrinsics, {320, 240}, 2.0);
  Eigen::Vector2d pixel;
  if (!uwv::project(target.intrinsics, uwv::target_from_source(target, source) * x_in_source, pixel)) return 1;
  std::printf("pixel %.2f %.2f\n", pixel.x(), pixel.y());
}
