// SPDX-License-Identifier: Apache-2.0
#include "bench/true_clip.h"

#include <filesystem>
#include <fstream>

#include "bench/stereo_pairs.h"
#include "uwv/io/cameras_file.h"
#include "uwv/io/depth_source.h"
#include "uwv/io/frame_source.h"

namespace uwv::bench {
namespace {

std::vector<ImageRgb> read_pictures(const std::string& path, const FrameRange& range, const ResizePolicy& resize,
                                    Size& full) {
  Monitor monitor;
  ClipOptions options;
  options.start = range.start;
  options.stride = range.stride;
  options.max_frames = range.max_frames;
  options.resize = resize;
  const auto source = open_clip(path, options, monitor);
  full = source->info().source_size;
  std::vector<ImageRgb> out;
  for (ImageRgb picture;
       static_cast<long>(out.size()) < source->frames() && source->read(static_cast<long>(out.size()), picture);)
    out.push_back(picture);
  return out;
}

void read_depths(const std::string& path, double scale, const FrameRange& range, TrueClip& clip) {
  Monitor monitor;
  DepthOptions options;
  options.scale = scale;
  options.start = range.start;
  options.stride = range.stride;
  const auto source = open_depth(path, options, monitor);
  for (DepthMap depth; clip.depths.size() < clip.frames.size();) {
    if (!source->read(static_cast<long>(clip.depths.size()), depth))
      fail(ErrorCode::size_mismatch, "{}: has {} depths for {} pictures", path, clip.depths.size(), clip.frames.size());
    clip.depths.push_back(resize_depth(depth, clip.frames.front().size()));
  }
}

/// For pictures of another size than the cameras'.
void take_cameras(const std::vector<Camera>& cameras, const std::string& path, const FrameRange& range,
                  TrueClip& clip) {
  for (std::size_t i = 0; i < clip.frames.size(); ++i) {
    const std::size_t source = static_cast<std::size_t>(range.start) + i * static_cast<std::size_t>(range.stride);
    if (source >= cameras.size())
      fail(ErrorCode::size_mismatch, "{}: has {} poses, picture number {} has none", path, cameras.size(), source);
    clip.cameras.push_back(cameras[source]);
  }
  for (Camera& camera : clip.cameras) {
    camera.intrinsics = camera.intrinsics.resized(camera.size, clip.frames.front().size());
    camera.size = clip.frames.front().size();
  }
}

void read_saved_clip(const std::string& folder, const FrameRange& range, const ResizePolicy& resize, TrueClip& clip) {
  Monitor monitor;
  Size full;
  clip.frames = read_pictures(folder + "/image", range, resize, full);
  read_depths(folder + "/depth.npz", 1, range, clip);
  take_cameras(read_cameras(folder + "/cameras.json", {}, monitor).cameras, folder + "/cameras.json", range, clip);
  if (!std::filesystem::exists(folder + "/foreground")) return;
  for (const ImageRgb& figure : read_pictures(folder + "/foreground", range, resize, full)) {
    ValidityMask mask(figure.size(), 1);
    // Resized edges are grey: whatever has some of the figure in it moves.
    for (std::size_t i = 0; i < mask.pixels().size(); ++i) mask.pixels()[i] = figure.pixels()[i].r == 0;
    clip.static_pixels.push_back(std::move(mask));
  }
  if (clip.static_pixels.size() != clip.frames.size())
    fail(ErrorCode::size_mismatch, "{}/foreground: has {} masks for {} pictures", folder, clip.static_pixels.size(),
         clip.frames.size());
}

void read_depth_recording(const std::string& folder, const FrameRange& range, const ResizePolicy& resize,
                          TrueClip& clip) {
  Monitor monitor;
  Size full;
  clip.frames = read_pictures(folder + "/image", range, resize, full);
  read_depths(folder + "/depth", 0.001, range, clip);
  const Intrinsics lens = Intrinsics::from_integer_centres(525, 525, 319.5, 239.5).resized({640, 480}, full);
  const std::string poses = folder + "/test_scene/trajectory.log";
  take_cameras(read_cameras(poses, {.size = full, .intrinsics = lens}, monitor).cameras, poses, range, clip);
}

/// Its cameras have y up and a right-handed name for a left-handed frame. Mirroring camera and world alike gives the
/// same pictures from cameras with y down.
Rigid3 mirrored(const Rigid3& world_from_cam) {
  const Eigen::Vector3d flip(1, -1, 1);
  return {flip.asDiagonal() * world_from_cam.rotation * flip.asDiagonal(),
          flip.asDiagonal() * world_from_cam.translation};
}

void read_icl_recording(const std::string& folder, const FrameRange& range, const ResizePolicy& resize,
                        TrueClip& clip) {
  Size full;
  clip.frames = read_pictures(folder + "/color", range, resize, full);
  read_depths(folder + "/depth", 1.0 / 5000, range, clip);
  const Intrinsics lens = Intrinsics::from_integer_centres(481.2, 480, 319.5, 239.5).resized({640, 480}, full);
  std::ifstream file(folder + "/pose.txt");
  std::vector<Camera> cameras;
  double x = 0, y = 0, z = 0, qx = 0, qy = 0, qz = 0, qw = 0;
  while (file >> x >> y >> z >> qx >> qy >> qz >> qw) {
    const Eigen::Quaterniond turn(qw, qx, qy, qz);
    cameras.push_back({lens, mirrored({turn.normalized().toRotationMatrix(), {x, y, z}}), full});
  }
  take_cameras(cameras, folder + "/pose.txt", range, clip);
}

}  // namespace

TrueClip read_true_clip(const std::string& folder, const FrameRange& range, const ResizePolicy& resize) {
  const auto has = [&](const char* name) { return std::filesystem::exists(folder + name); };
  TrueClip clip;
  clip.name = std::filesystem::path(folder).lexically_normal().filename().string();
  if (has("/cameras.json"))
    read_saved_clip(folder, range, resize, clip);
  else if (has("/test_scene/trajectory.log"))
    read_depth_recording(folder, range, resize, clip);
  else if (has("/pose.txt"))
    read_icl_recording(folder, range, resize, clip);
  else if (is_stereo_pair(folder))
    return read_stereo_pair(folder, resize);
  else
    fail(ErrorCode::format_unknown,
         "{}: holds none of cameras.json, test_scene/trajectory.log and pose.txt and no stereo pair, so its cameras "
         "are not "
         "known",
         folder);
  return clip;
}

}  // namespace uwv::bench
