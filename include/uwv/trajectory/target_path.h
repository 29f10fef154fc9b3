// SPDX-License-Identifier: Apache-2.0
// The target cameras of a run: a trajectory spec applied to a clip.
#pragma once

#include <span>
#include <vector>

#include "uwv/core/camera.h"
#include "uwv/trajectory/subject_world.h"
#include "uwv/trajectory/trajectory_spec.h"

namespace uwv {

/// One frame of the wanted video.
struct TargetFrame {
  Camera camera;          ///< camera.world_from_cam: "world" is the subject world (subject_world.h).
  long source_frame = 0;  ///< The moment it shows, an index into the source's frames.
  friend bool operator==(const TargetFrame&, const TargetFrame&) = default;
};

struct TargetPath {
  std::vector<TargetFrame> frames;  ///< At least one.
};

/// What a path needs to know about the clip.
struct PathContext {
  Intrinsics intrinsics;  ///< Of source frame 0, in pixels of `size`; every target frame has them times its zoom.
  Size size;              ///< Of the target pictures.
  SubjectWorld world;
  /// The source cameras in the subject world, one per source frame; one alone stands for a camera that never moves.
  std::vector<Rigid3> subject_from_source;
  long source_frames = 1;
  bool is_photo = false;  ///< The official photo mode ignores radius_scale, and its default length is 81 frames.

  /// Throws std::invalid_argument: sizes and focal lengths that are not positive, counts that do not fit.
  void check() const;
};

/// The context of a clip: places the subject world by the spec's elevation and radius ("auto" = `median_depth` of
/// source frame 0). `world_from_cam` holds the source cameras, one per frame or a single one. Throws
/// Error(value_invalid) when the radius is "auto" and the median depth is not positive.
PathContext make_context(const TrajectorySpec& spec, const Intrinsics& intrinsics, Size size,
                         std::span<const Rigid3> world_from_cam, long source_frames, double median_depth,
                         bool is_photo);

/// The number of frames the path will have.
long path_frames(const TrajectorySpec& spec, const PathContext& context);

/// All target frames. Throws Error(value_invalid), naming spec.name and the JSON pointer, for values that do not fit
/// this clip; std::invalid_argument when the cameras of a `cameras_file` have not been filled in.
TargetPath build_path(const TrajectorySpec& spec, const PathContext& context);

/// How far a path departs from the source cameras that saw the same moments.
struct PathSummary {
  double max_rotation_deg = 0;  ///< Largest angle between target and source orientation, [0, 180].
  double max_translation = 0;   ///< Largest distance between target and source camera, in radii.
  double max_zoom = 1;          ///< Largest focal length, relative to the source's.
  /// The first frame at which the camera comes back towards the source (by more than 1 % of the largest departure), -1
  /// if none. The paper accumulates visibility along the path by a product over its frames, which suits paths that only
  /// depart: on the way back, what was occluded in between stays masked.
  long first_return = -1;

  bool monotone() const { return first_return < 0; }
};
PathSummary summarize(const TargetPath& path, const PathContext& context);

}  // namespace uwv
