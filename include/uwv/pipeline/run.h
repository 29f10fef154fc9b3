// SPDX-License-Identifier: Apache-2.0
// The main job: a clip in, the same moments seen along another camera path out.
//
//   geometry       depth and source cameras, where none are given: geometry/ (see docs/geometry.md)
//   conditioning   decode, Algorithm 1, encode: colour.mp4, generate_mask.mp4 (white = generate), depth, masks
//   completion     fill the holes, by the video diffusion model or as a draft: result.mp4
//   presentation   contact_sheet.png, cameras_source.json, cameras_target.json, points_*.ply
//   evaluation     against a real picture from another camera: reference_comparison.png
//   run.json       what was asked, read, done and left out, with seconds and peak bytes per stage
//
// Stages appear in the output folder only when whole. A second run of the same options over the same inputs skips what
// is finished and gives the same bytes; other options redo what they affect. Memory does not grow with the clip.
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "uwv/core/monitor.h"
#include "uwv/geometry/layers.h"
#include "uwv/model/depth_network.h"
#include "uwv/model/view_completion.h"
#include "uwv/pipeline/run_options.h"
#include "uwv/pipeline/scene_look.h"

namespace uwv {

/// One stage of a run.
struct StageSummary {
  enum class Status {
    done,     ///< Made by this run.
    resumed,  ///< Found finished, of the same options and inputs.
    skipped,  ///< The options don't ask for it.
  };
  std::string name;
  Status status = Status::done;
  std::string reason;            ///< Why it was skipped.
  double seconds = 0;            ///< Of the run that made it.
  std::uint64_t peak_bytes = 0;  ///< Largest resident memory of the process meanwhile.
  nlohmann::ordered_json facts;  ///< Frames, passes, what was skipped and why: as in run.json.
  std::vector<std::string> files;
};

struct RunSummary {
  std::string out;  ///< The output folder.
  SceneLook look;
  std::vector<StageSummary> stages;
  std::vector<std::string> warnings;

  /// A few lines for people.
  std::string report() const;
};

/// Hears of the look at the scene before the work begins; may be empty.
using LookListener = std::function<void(const SceneLook&)>;

/// What a run may use that this library does not link, because not everybody has it: the caller hands it in.
struct RunComponents {
  /// uwv::model's open_depth_network. Empty: --depth-model is refused.
  std::function<std::unique_ptr<DepthNetwork>(const std::string& folder)> open_depth_network;
  /// uwv::model's open_foreground_network and open_foreground_tracker. Empty: a folder as --saliency-model, and
  /// --segmenter, are refused.
  std::function<std::unique_ptr<ForegroundFinder>(const std::string& folder)> open_foreground_network;
  std::function<std::unique_ptr<ForegroundTracker>(const std::string& folder)> open_foreground_tracker;
  /// uwv::model's check_checkpoint and complete_views. Empty: --model is refused.
  std::function<void(const ModelOptions& options)> check_checkpoint;
  std::function<CompletionSummary(const ModelOptions& options, const RenderedClip& clip, const CompletedClip& out,
                                  int threads, Monitor& monitor)>
      complete_views;
};

/// Does the job. Warnings and progress go to `monitor`, from the calling thread. Throws std::invalid_argument when
/// options.check() does, Error for everything wrong with the inputs or the output folder, Error(cancelled) when the
/// monitor stops it. Then nothing is left behind but stages that were finished.
RunSummary run(const RunOptions& options, Monitor& monitor, const LookListener& on_look = {},
               const RunComponents& components = {});

/// Only the look before the run: opens the inputs, writes nothing.
SceneLook look(const RunOptions& options, Monitor& monitor);

}  // namespace uwv
