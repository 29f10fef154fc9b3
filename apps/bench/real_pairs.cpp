// SPDX-License-Identifier: Apache-2.0
#include "bench/real_pairs.h"

#include <algorithm>

#include "uwv/io/cameras_file.h"
#include "uwv/io/depth_file.h"
#include "uwv/io/depth_source.h"
#include "uwv/io/frame_source.h"

namespace uwv::bench {
namespace {

// docs/sources.md. Both cameras' principal points count pixel centres the same way, so which way does not matter: only
// their difference moves a pixel.
constexpr Intrinsics left_lens{994.978, 994.978, 311.193, 254.877};
constexpr double doffs = 31.086;
constexpr double baseline = 193.001;  // mm, which makes depth mm

constexpr int motorcycle_steps = 8;

ImageRgb read_frame(FrameSource& clip, long index) {
  ImageRgb picture;
  if (index >= clip.frames() || !clip.read(index, picture))
    fail(ErrorCode::size_mismatch, "{}: has {} pictures, the pair wants number {}", clip.info().path, clip.frames(),
         index);
  return picture;
}

std::unique_ptr<FrameSource> open_pictures(const std::string& path, const ResizePolicy& resize, Monitor& monitor) {
  ClipOptions options;
  options.max_frames = 0;
  options.resize = resize;
  return open_clip(path, options, monitor);
}

DepthMap depth_from_disparity(DepthMap disparity) {
  for (float& value : disparity.pixels())
    if (value > 0) value = static_cast<float>(left_lens.fx * baseline / (value + doffs));
  return disparity;
}

/// The frames of a recording, opened once for all pairs.
class Recording {
 public:
  Recording(const std::string& folder, const ResizePolicy& resize)
      : folder_(folder),
        pictures_(open_pictures(folder + "/image", resize, monitor_)),
        depths_(open_depth(folder + "/depth", {}, monitor_)) {
    const Size full = pictures_->info().source_size;
    const Intrinsics lens = Intrinsics::from_integer_centres(525, 525, 319.5, 239.5).resized({640, 480}, full);
    track_ = read_cameras(folder + "/test_scene/trajectory.log", {.size = full, .intrinsics = lens}, monitor_);
  }

  RealPair pair(long from, long to) {
    require_pose(std::max(from, to));
    RealPair pair;
    pair.name = fmt::format("rgbd {}:{}", from, to);
    pair.source = camera(from);
    pair.colour = read_frame(*pictures_, from);
    pair.depth = depth(from);
    const long step = to > from ? 1 : -1;
    for (long i = from; i != to; i += step) pair.path.push_back(camera(i + step));
    pair.truth = read_frame(*pictures_, to);
    pair.truth_depth = depth(to);
    return pair;
  }

 private:
  void require_pose(long index) const {
    if (static_cast<std::size_t>(index) >= track_.cameras.size())
      fail(ErrorCode::size_mismatch, "{}/test_scene/trajectory.log: has {} poses, the pair wants number {}", folder_,
           track_.cameras.size(), index);
  }

  Camera camera(long index) const {
    Camera camera = track_.cameras[static_cast<std::size_t>(index)];
    camera.intrinsics = camera.intrinsics.resized(camera.size, pictures_->info().size);
    camera.size = pictures_->info().size;
    return camera;
  }

  DepthMap depth(long index) {
    DepthMap depth;
    if (!depths_->read(index, depth))
      fail(ErrorCode::size_mismatch, "{}/depth: has {} files, the pair wants number {}", folder_, depths_->frames(),
           index);
    return resize_depth(depth, pictures_->info().size);
  }

  std::string folder_;
  Monitor monitor_;
  std::unique_ptr<FrameSource> pictures_;
  std::unique_ptr<DepthSource> depths_;
  CameraTrack track_;
};

}  // namespace

RealPair motorcycle_pair(const std::string& folder, const ResizePolicy& resize) {
  Monitor monitor;
  const auto left = open_pictures(folder + "/motorcycle_left.png", resize, monitor);
  const auto right = open_pictures(folder + "/motorcycle_right.png", resize, monitor);
  const Size full = left->info().source_size, size = left->info().size;
  const DepthMap disparity = read_depth_file(folder + "/motorcycle_disp.npz", {.scale = 1, .key = ""});
  if (right->info().source_size != full || disparity.size() != full)
    fail(ErrorCode::size_mismatch, "{}: left picture is {}x{}, right {}x{}, disparity {}x{}; wanted one size", folder,
         full.width, full.height, right->info().source_size.width, right->info().source_size.height, disparity.width(),
         disparity.height());

  RealPair pair;
  pair.name = "motorcycle";
  pair.source = {left_lens.resized(full, size), {}, size};
  pair.colour = read_frame(*left, 0);
  pair.depth = resize_depth(depth_from_disparity(disparity), size);
  for (int k = 1; k <= motorcycle_steps; ++k) {
    const double share = static_cast<double>(k) / motorcycle_steps;
    Intrinsics lens = left_lens;
    lens.cx += share * doffs;
    Camera camera{lens.resized(full, size), {}, size};
    camera.world_from_cam.translation.x() = share * baseline;
    pair.path.push_back(camera);
  }
  pair.truth = read_frame(*right, 0);
  return pair;
}

std::vector<RealPair> rgbd_pairs(const std::string& folder, const std::vector<std::pair<long, long>>& pairs,
                                 const ResizePolicy& resize) {
  Recording recording(folder, resize);
  std::vector<RealPair> all;
  all.reserve(pairs.size());
  for (const auto& [from, to] : pairs) all.push_back(recording.pair(from, to));
  return all;
}

}  // namespace uwv::bench
