// SPDX-License-Identifier: Apache-2.0
// A run with everything decided: inputs opened, path built, scene looked at. Making it writes nothing.
#pragma once

#include <memory>

#include "pipeline/scene_choices.h"
#include "pipeline/source_clip.h"
#include "uwv/pipeline/scene_look.h"
#include "uwv/trajectory/target_path.h"

namespace uwv::pipeline {

struct Plan {
  RunOptions options;
  std::unique_ptr<SourceClip> source;
  TrajectorySpec trajectory;
  PathContext context;
  TargetPath path;
  SceneLook look;
  SceneChoices choices;
  double fps = 16;  ///< Of the videos to be written.

  Size size() const { return source->size(); }
  long frames() const { return static_cast<long>(path.frames.size()); }
  /// What the renderer is told; reliability is decided.
  OcclusionOptions occlusion() const;
  /// How visibility accumulates along the path, and why.
  Accumulation accumulation() const;
  std::string accumulation_reason() const;
  /// Whether the reliability filter is on, and why.
  std::string reliability() const;
  /// Source camera in the subject world, where the path's cameras are given too.
  Camera source_camera(long index) const;
  /// A target camera in the world of the source cameras.
  Camera in_source_world(const Camera& target) const;
};

/// `geometry` is the folder with estimated depth and cameras, where the options name none. Throws Error for everything
/// that is wrong with the inputs. `options` have been checked.
Plan make_plan(const RunOptions& options, const std::optional<GeometryFolder>& geometry, Monitor& monitor);

/// Throws Error when the trajectory the options name is none, before anything that takes long is begun.
void check_trajectory(const RunOptions& options);

/// True for inputs that only the completion by the model reads.
bool is_model_input(std::string_view name);

/// Names of every input file or folder of the options; empty ones are left out.
std::vector<std::pair<std::string, std::string>> named_inputs(const RunOptions& options);

}  // namespace uwv::pipeline
