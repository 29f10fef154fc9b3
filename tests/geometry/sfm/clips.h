// SPDX-License-Identifier: Apache-2.0
// Ray-cast clips with known cameras, for tests of structure from motion.
#pragma once

#include <functional>
#include <numbers>
#include <vector>

#include "uwv/eval/stock_scenes.h"
#include "uwv/eval/trajectory_error.h"
#include "uwv/geometry/structure_from_motion.h"

namespace uwv::testing {

inline constexpr double degree = std::numbers::pi / 180;
inline constexpr Size clip_size{320, 240};

struct Clip {
  std::vector<ImageRgb> frames;
  std::vector<Camera> truth;

  std::vector<Rigid3> truth_poses() const {
    std::vector<Rigid3> out;
    for (const Camera& camera : truth) out.push_back(camera.world_from_cam);
    return out;
  }
};

/// `camera_at(i, source)` gives frame i's camera; time runs from 0 to the scene's duration.
inline Clip film(const StockScene& stock, int frames, const std::function<Camera(int, const Camera&)>& camera_at) {
  ThreadPool pool;
  Clip clip;
  for (int i = 0; i < frames; ++i) {
    clip.truth.push_back(camera_at(i, stock.source));
    const double time = frames > 1 ? stock.duration * i / (frames - 1) : 0;
    clip.frames.push_back(render(stock.scene, clip.truth.back(), time, pool, 2).colour);
  }
  return clip;
}

/// `source` moved by `shift` (its own axes) and turned to the right by `yaw` radians.
inline Camera moved(const Camera& source, const Eigen::Vector3d& shift, double yaw = 0) {
  Camera out = source;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()).toRotationMatrix();
  out.world_from_cam = source.world_from_cam * Rigid3{turn, shift};
  return out;
}

inline StockOptions small_clip() {
  StockOptions out;
  out.size = clip_size;
  return out;
}

inline SfmOptions with_lens(const Clip& clip) {
  SfmOptions out;
  out.intrinsics = clip.truth.front().intrinsics;
  return out;
}

inline SfmResult solve(const Clip& clip, const SfmOptions& options = {}, int threads = 2) {
  ThreadPool pool(threads);
  Monitor monitor;
  return structure_from_motion(clip.frames, options, pool, monitor);
}

inline TrajectoryError error_of(const SfmResult& result, const Clip& clip) {
  std::vector<Rigid3> poses;
  for (const Camera& camera : result.cameras) poses.push_back(camera.world_from_cam);
  return trajectory_error(poses, clip.truth_poses());
}

}  // namespace uwv::testing
