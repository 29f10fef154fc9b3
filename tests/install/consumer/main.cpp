// SPDX-License-Identifier: Apache-2.0
// Moves the camera 0.4 to the left of a wall 2 away: the wall moves 10 pixels to the right, and 54 of its 64 columns
// stay in the picture.
#include <uwv/render/rasterizer.h>

#include <cstdio>

int main() {
  uwv::Camera source;
  source.size = {64, 48};
  source.intrinsics = {50, 50, 32, 24};
  uwv::Camera target = source;
  target.world_from_cam.translation = {-0.4, 0, 0};
  const uwv::DepthMap wall(source.size, 2.0F);

  uwv::ThreadPool pool;
  uwv::ValidityMask covered;
  uwv::make_cpu_rasterizer(pool)->coverage({.camera = source, .depth = &wall}, target, {}, covered);

  Eigen::Vector2d pixel;
  const Eigen::Vector3d x_in_source = uwv::unproject(source.intrinsics, {32, 24}, 2.0);
  if (!uwv::project(target.intrinsics, uwv::target_from_source(target, source) * x_in_source, pixel)) return 1;
  std::printf("pixel %.2f %.2f, %zu pixels covered\n", pixel.x(), pixel.y(), covered.count());
}
