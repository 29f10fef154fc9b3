// SPDX-License-Identifier: Apache-2.0
#include "pipeline/source_clip.h"

#include <algorithm>

#include <filesystem>
#include "uwv/geometry/depth_composite.h"

namespace uwv::pipeline {
namespace {

std::unique_ptr<FrameSource> open_foreground(const RunOptions& options, const std::optional<GeometryFolder>& geometry,
                                             Size size, long clip_frames, Monitor& monitor) {
  const std::string path = options.foreground.empty() && geometry ? geometry->foreground() : options.foreground;
  if (path.empty()) return nullptr;
  ClipOptions as_clip = clip_options(options);
  if (options.foreground.empty()) as_clip.start = 0, as_clip.stride = 1;
  as_clip.resize = {.mode = ResizePolicy::Mode::exact, .exact = size};
  std::unique_ptr<FrameSource> masks = open_clip(path, as_clip, monitor);
  if (masks->frames() < clip_frames)
    fail(ErrorCode::size_mismatch, "{}: found {} foreground masks, wanted {}, one per frame of {}", path,
         masks->frames(), clip_frames, options.video);
  return masks;
}

ValidityMask to_mask(const ImageRgb& picture) {
  ValidityMask mask(picture.size());
  std::transform(picture.pixels().begin(), picture.pixels().end(), mask.pixels().begin(),
                 [](const Rgb8& p) { return static_cast<std::uint8_t>(p.r + p.g + p.b > 3 * 127); });
  return mask;
}

/// The official code's ring of unknown depth around the foreground (geometry sheet 4.5).
DepthMap with_ring(const DepthMap& depth, const ValidityMask& foreground) {
  ForegroundMask mask(foreground.size());
  std::copy(foreground.pixels().begin(), foreground.pixels().end(), mask.pixels().begin());
  return composite_depth(depth, depth, mask, {.ring = true});
}

/// Takes out what `foreground` marks, and the pixels beside it: masks end a little early, and colours mix at edges.
void leave_out_around(const ValidityMask& foreground, ValidityMask& mask) {
  constexpr int margin = 2;
  for (int y = 0; y < mask.height(); ++y)
    for (int x = 0; x < mask.width(); ++x) {
      if (foreground(x, y) == 0) continue;
      for (int j = std::max(0, y - margin); j <= std::min(mask.height() - 1, y + margin); ++j)
        for (int i = std::max(0, x - margin); i <= std::min(mask.width() - 1, x + margin); ++i) mask(i, j) = 0;
    }
}

/// Takes out what a geometry folder's confidence.npz, which may be of another size, calls a guess.
void leave_out_guesses(NpyArrayReader& confidence, long index, ValidityMask& mask) {
  constexpr float measured = 128;
  const std::vector<std::size_t>& shape = confidence.header().shape;
  if (shape.size() != 3 || static_cast<std::size_t>(index) >= shape[0] || confidence.slice_values() == 0) return;
  std::vector<float> values(confidence.slice_values());
  confidence.read(static_cast<std::size_t>(index), std::span<float>(values));
  for (int y = 0; y < mask.height(); ++y)
    for (int x = 0; x < mask.width(); ++x) {
      const std::size_t v = static_cast<std::size_t>(y) * shape[1] / static_cast<std::size_t>(mask.height());
      const std::size_t u = static_cast<std::size_t>(x) * shape[2] / static_cast<std::size_t>(mask.width());
      if (values[v * shape[2] + u] < measured) mask(x, y) = 0;
    }
}

/// The options with which a geometry folder's depth and normals are read: it holds the used frames only. Throws
/// Error(size_mismatch) when it is of other frames.
RunOptions with_depth_of(const GeometryFolder& folder, const RunOptions& options, long clip_frames) {
  if (folder.start != options.start || folder.stride != options.stride || folder.frames < clip_frames)
    fail(
        ErrorCode::size_mismatch,
        "{}: holds the geometry of {} frames from {} on, every {}; wanted {} frames from {} on, every {}; use the same "
        "--start, --stride and --max-frames, or have it estimated anew",
        folder.path, folder.frames, folder.start, folder.stride, clip_frames, options.start, options.stride);
  RunOptions depth_only = options;
  depth_only.depth = folder.depth();
  if (options.normals.empty() && folder.has_normals) depth_only.normals = folder.normals();
  depth_only.depth_kind = DepthKind::depth;
  depth_only.depth_scale.reset();
  depth_only.depth_key.clear();
  depth_only.start = 0;
  depth_only.stride = 1;
  return depth_only;
}

}  // namespace

ClipOptions clip_options(const RunOptions& options) {
  return {.start = options.start,
          .stride = options.stride,
          .max_frames = options.max_frames,
          .resize = resize_policy(options)};
}

ResizePolicy resize_policy(const RunOptions& options) {
  ResizePolicy policy;
  policy.max_side = options.max_side;
  if (options.no_resize) policy.mode = ResizePolicy::Mode::none;
  if (options.size != Size{}) policy.mode = ResizePolicy::Mode::exact, policy.exact = options.size;
  return policy;
}

SourceClip::SourceClip(const RunOptions& options, const std::optional<GeometryFolder>& geometry, Monitor& monitor)
    : foreground_ring_(options.foreground_ring), frames_(open_clip(options.video, clip_options(options), monitor)) {
  open_cameras(options, geometry, monitor);
  const Size full_size = info().source_size;
  const RunOptions of_depth = geometry ? with_depth_of(*geometry, options, frames()) : options;
  depth_.emplace(of_depth, full_size, size(), intrinsics_.front().resized(size(), full_size), frames(), monitor);
  foreground_ = open_foreground(options, geometry, size(), frames(), monitor);
  if (options.layers != LayerChoice::off) open_background(options, geometry, monitor);
  if (geometry && std::filesystem::exists(geometry->confidence())) confidence_.emplace(geometry->confidence());
  const RunOptions& of_normals = options.normals.empty() ? of_depth : options;
  if (!of_normals.normals.empty()) normals_.emplace(of_normals, size(), frames());
}

void SourceClip::open_background(const RunOptions& options, const std::optional<GeometryFolder>& geometry,
                                 Monitor& monitor) {
  ClipOptions as_clip = clip_options(options);
  as_clip.max_frames = 0;
  as_clip.resize = {.mode = ResizePolicy::Mode::exact, .exact = size()};
  if (!options.background_depth.empty()) {
    RunOptions of_depth = options;
    of_depth.depth = options.background_depth;
    of_depth.disparity.clear();
    background_ = open_clip(options.background, as_clip, monitor);
    background_depth_.emplace(of_depth, info().source_size, size(),
                              intrinsics_.front().resized(size(), info().source_size), frames(), monitor);
  } else if (geometry && geometry->has_background) {
    as_clip.start = 0, as_clip.stride = 1;
    background_ = open_clip(geometry->background(), as_clip, monitor);
    RunOptions of_depth = with_depth_of(*geometry, options, frames());
    of_depth.depth = geometry->background_depth();
    background_depth_.emplace(of_depth, info().source_size, size(),
                              intrinsics_.front().resized(size(), info().source_size), frames(), monitor);
  }
  if (background_ && background_->frames() < frames())
    fail(ErrorCode::size_mismatch, "{}: found {} pictures of the background, wanted {}, one per frame of {}",
         background_->info().path, background_->frames(), frames(), options.video);
}

void SourceClip::leave_out_background() {
  background_.reset();
  background_depth_.reset();
  last_.reset();
}

void SourceClip::open_cameras(const RunOptions& options, const std::optional<GeometryFolder>& geometry,
                              Monitor& monitor) {
  const Size full_size = info().source_size;
  const std::optional<Intrinsics> by_number = intrinsics_by_number(options, full_size);
  const Intrinsics assumed = assumed_intrinsics(full_size);
  if (!options.cameras.empty())
    take_cameras(options.cameras, {.size = full_size, .intrinsics = by_number.value_or(assumed)}, options.start,
                 options.stride, by_number, monitor);
  else if (geometry)
    take_cameras(geometry->cameras(), {.size = full_size, .intrinsics = assumed}, 0, 1, by_number, monitor);
  if (!intrinsics_.empty()) return;
  if (!by_number)
    monitor.warn(fmt::format(
        "no intrinsics given: assuming a horizontal field of view of {} degrees; set --fov or --fx", assumed_fov_deg));
  world_from_cam_ = {Rigid3{}};
  intrinsics_ = {by_number.value_or(assumed).resized(full_size, size())};
}

void SourceClip::take_cameras(const std::string& path, const CamerasFileOptions& read, long first, long stride,
                              const std::optional<Intrinsics>& by_number, Monitor& monitor) {
  cameras_given_ = true;
  const CameraTrack track = read_cameras(path, read, monitor);
  const Size full_size = info().source_size;
  const long available = static_cast<long>(track.cameras.size());
  const long last = first + (frames() - 1) * stride;
  if (available <= last)
    fail(ErrorCode::size_mismatch, "{}: found {} cameras, wanted at least {}: {} uses {} frames up to number {}", path,
         available, last + 1, info().path, frames(), last);
  for (long i = 0; i < frames(); ++i) {
    const Camera& camera = track.cameras[static_cast<std::size_t>(first + i * stride)];
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

ValidityMask SourceClip::lasting_points(const SourceData& data) {
  ValidityMask lasting(size());
  std::transform(data.depth.pixels().begin(), data.depth.pixels().end(), lasting.pixels().begin(),
                 [](float z) { return static_cast<std::uint8_t>(z > 0); });
  if (data.foreground) leave_out_around(*data.foreground, lasting);
  if (confidence_) leave_out_guesses(*confidence_, data.index, lasting);
  return lasting;
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
    if (foreground_ring_) data->depth = with_ring(data->depth, *data->foreground);
  }
  if (background_) {
    BackgroundData& background = data->background.emplace();
    if (!background_->read(index, background.colour)) return nullptr;
    background_depth_->read(index, background.depth);
  }
  last_ = data;
  return last_;
}

}  // namespace uwv::pipeline
