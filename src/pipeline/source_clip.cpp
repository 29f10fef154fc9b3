// SPDX-License-Identifier: Apache-2.0
#include "pipeline/source_clip.h"

#include <algorithm>
#include <numbers>

#include "uwv/io/cameras_file.h"

namespace uwv::pipeline {
namespace {

constexpr double assumed_fov_deg = 60;  // of a phone's main camera held upright or a 35 mm lens: the usual guess

ClipOptions clip_options(const RunOptions& options) {
  return {.start = options.start,
          .stride = options.stride,
          .max_frames = options.max_frames,
          .resize = resize_policy(options)};
}

std::unique_ptr<FrameSource> open_foreground(const RunOptions& options, Size size, long clip_frames, Monitor& monitor) {
  if (options.foreground.empty()) return nullptr;
  ClipOptions as_clip = clip_options(options);
  as_clip.resize = {.mode = ResizePolicy::Mode::exact, .exact = size};
  std::unique_ptr<FrameSource> masks = open_clip(options.foreground, as_clip, monitor);
  if (masks->frames() < clip_frames)
    fail(ErrorCode::size_mismatch, "{}: found {} foreground masks, wanted {}, one per frame of {}", options.foreground,
         masks->frames(), clip_frames, options.video);
  return masks;
}

ValidityMask to_mask(const ImageRgb& picture) {
  ValidityMask mask(picture.size());
  std::transform(picture.pixels().begin(), picture.pixels().end(), mask.pixels().begin(),
                 [](const Rgb8& p) { return static_cast<std::uint8_t>(p.r + p.g + p.b > 3 * 127); });
  return mask;
}

}  // namespace

ResizePolicy resize_policy(const RunOptions& options) {
  ResizePolicy policy;
  policy.max_side = options.max_side;
  if (options.no_resize) policy.mode = ResizePolicy::Mode::none;
  if (options.size != Size{}) policy.mode = ResizePolicy::Mode::exact, policy.exact = options.size;
  return policy;
}

SourceClip::SourceClip(const RunOptions& options, Monitor& monitor)
    : frames_(open_clip(options.video, clip_options(options), monitor)) {
  open_cameras(options, monitor);
  const Size full_size = info().source_size;
  depth_.emplace(options, full_size, size(), intrinsics_.front().resized(size(), full_size), frames(), monitor);
  foreground_ = open_foreground(options, size(), frames(), monitor);
  if (!options.normals.empty()) normals_.emplace(options, size(), frames());
}

void SourceClip::open_cameras(const RunOptions& options, Monitor& monitor) {
  const Size full_size = info().source_size;
  const std::optional<Intrinsics> by_number = intrinsics_by_number(options, full_size);
  const Intrinsics assumed = Intrinsics::from_fov_x(assumed_fov_deg * std::numbers::pi / 180, full_size);
  if (options.cameras.empty()) {
    if (!by_number)
      monitor.warn(
          fmt::format("no intrinsics given: assuming a horizontal field of view of {} degrees; set --fov or "
                      "--fx",
                      assumed_fov_deg));
    world_from_cam_ = {Rigid3{}};
    intrinsics_ = {by_number.value_or(assumed).resized(full_size, size())};
    return;
  }
  cameras_given_ = true;
  const CameraTrack track =
      read_cameras(options.cameras, {.size = full_size, .intrinsics = by_number.value_or(assumed)}, monitor);
  const long available = static_cast<long>(track.cameras.size());
  const long last = options.start + (frames() - 1) * options.stride;
  if (available <= last)
    fail(ErrorCode::size_mismatch, "{}: found {} cameras, wanted at least {}: {} uses {} frames up to number {}",
         options.cameras, available, last + 1, options.video, frames(), last);
  for (long i = 0; i < frames(); ++i) {
    const Camera& camera = track.cameras[static_cast<std::size_t>(options.start + i * options.stride)];
    world_from_cam_.push_back(camera.world_from_cam);
    intrinsics_.push_back(by_number ? by_number->resized(full_size, size())
                                    : camera.intrinsics.resized(camera.size, size()));
  }
}

Rigid3 SourceClip::world_from_cam(long index) const {
  return world_from_cam_[world_from_cam_.size() == 1 ? 0 : static_cast<std::size_t>(index)];
}

const Intrinsics& SourceClip::intrinsics(long index) const {
  return intrinsics_[intrinsics_.size() == 1 ? 0 : static_cast<std::size_t>(index)];
}

std::shared_ptr<const SourceData> SourceClip::read(long index) {
  if (last_ && last_->index == index) return last_;
  if (index >= frames()) return nullptr;
  auto data = std::make_shared<SourceData>();
  data->index = index;
  if (!frames_->read(index, data->colour)) return nullptr;
  depth_->read(index, data->depth);
  if (normals_) data->slopes = normals_->read(index, intrinsics(index));
  if (foreground_) {
    ImageRgb mask;
    if (!foreground_->read(index, mask)) return nullptr;
    data->foreground = to_mask(mask);
  }
  last_ = data;
  return last_;
}

}  // namespace uwv::pipeline
