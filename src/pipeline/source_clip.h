// SPDX-License-Identifier: Apache-2.0
// Everything the inputs say about each frame of the clip, side by side at the working size.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "pipeline/depth_feed.h"
#include "pipeline/geometry_folder.h"
#include "pipeline/normal_feed.h"
#include "uwv/io/cameras_file.h"
#include "uwv/io/frame_source.h"
#include "uwv/io/npy.h"
#include "uwv/pipeline/run_options.h"
#include "uwv/render/occlusion.h"

namespace uwv::pipeline {

/// The scene behind the foreground, at one moment.
struct BackgroundData {
  ImageRgb colour;
  DepthMap depth;
};

/// One frame; everything has the working size.
struct SourceData {
  long index = 0;
  ImageRgb colour;
  DepthMap depth;
  std::optional<SlopeMap> slopes;
  std::optional<ValidityMask> foreground;
  std::optional<BackgroundData> background;

  /// The background alone, which must be there, as the renderer takes it.
  SourceFrame background_seen_by(const Camera& camera) const {
    return {.index = index,
            .camera = camera,
            .colour = &background->colour,
            .depth = &background->depth,
            .slopes = nullptr,
            .valid = nullptr,
            .foreground = nullptr};
  }
  /// As the renderer takes it, borrowed from here.
  SourceFrame seen_by(const Camera& camera) const {
    return {.index = index,
            .camera = camera,
            .colour = &colour,
            .depth = &depth,
            .slopes = slopes ? &*slopes : nullptr,
            .valid = nullptr,
            .foreground = foreground ? &*foreground : nullptr};
  }
};

/// The clip with its depth, cameras, foreground and normals, opened and checked against each other. Not for use by two
/// threads at once.
class SourceClip {
 public:
  /// `geometry` is where depth and cameras were estimated to; it stands for those the options don't name. Throws Error
  /// when an input is missing, damaged, or does not cover the clip's frames.
  SourceClip(const RunOptions& options, const std::optional<GeometryFolder>& geometry, Monitor& monitor);

  const ClipInfo& info() const { return frames_->info(); }
  Size size() const { return info().size; }
  long frames() const { return frames_->frames(); }
  bool has_foreground() const { return foreground_ != nullptr; }
  bool has_background() const { return background_ != nullptr; }
  /// Frames are read without their background from now on.
  void leave_out_background();
  bool has_cameras() const { return world_from_cam_.size() > 1 || cameras_given_; }

  /// Poses in the inputs' own world: one per frame, or one alone for a camera that never moves.
  const std::vector<Rigid3>& world_from_cam() const { return world_from_cam_; }
  Rigid3 world_from_cam(long index) const;
  /// For the working size.
  const Intrinsics& intrinsics(long index) const;

  /// The points of a frame that other moments show as well: measured (where the geometry says what was) and not of the
  /// foreground, nor right beside it.
  ValidityMask lasting_points(const SourceData& data);

  /// Frame `index`; the last one read is kept, so that asking again is free. Null when the clip turned out to end
  /// before it.
  std::shared_ptr<const SourceData> read(long index);

 private:
  void open_background(const RunOptions& options, const std::optional<GeometryFolder>& geometry, Monitor& monitor);
  void open_cameras(const RunOptions& options, const std::optional<GeometryFolder>& geometry, Monitor& monitor);
  void take_cameras(const std::string& path, const CamerasFileOptions& read, long first, long stride,
                    const std::optional<Intrinsics>& by_number, Monitor& monitor);

  bool foreground_ring_;
  std::unique_ptr<FrameSource> frames_;
  std::unique_ptr<FrameSource> foreground_, background_;
  std::optional<DepthFeed> depth_, background_depth_;
  std::optional<NpyArrayReader> confidence_;
  std::optional<NormalFeed> normals_;
  std::vector<Rigid3> world_from_cam_;
  std::vector<Intrinsics> intrinsics_;
  bool cameras_given_ = false;
  std::shared_ptr<const SourceData> last_;
};

/// How the options want the clip opened.
ClipOptions clip_options(const RunOptions& options);

/// The resize policy that the options ask for.
ResizePolicy resize_policy(const RunOptions& options);

}  // namespace uwv::pipeline
