// SPDX-License-Identifier: Apache-2.0
// The foreground of a clip whose camera does not show it by moving: what the first frame is about, followed through the
// others, or the masks the user gives.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "uwv/core/thread_pool.h"
#include "uwv/geometry/layers.h"
#include "uwv/pipeline/run.h"

namespace uwv::pipeline {

struct ClipForeground {
  std::vector<ForegroundMask> masks;  ///< One a frame; none when nothing stands out.
  std::string note;                   ///< What was found and by whom.
};

/// What finds the foreground of the first frame and follows it through the others.
struct ForegroundNetworks {
  std::unique_ptr<ForegroundFinder> finder;    ///< Null: what the options leave to find_clip_foreground().
  std::unique_ptr<ForegroundTracker> tracker;  ///< Null: optical flow.
};

/// Opens those the options name; throws Error when they cannot be used.
ForegroundNetworks open_foreground_networks(const RunOptions& options, const RunComponents& components);

/// Throws Error when the saliency network or the masks the options name cannot be used.
ClipForeground find_clip_foreground(const RunOptions& options, const ForegroundNetworks& networks,
                                    std::span<const ImageRgb> frames, ThreadPool& pool, Monitor& monitor);

/// The saliency network's file: the option's, else the first of UWV_MODELS/u2netp.onnx, .cache/models/u2netp.onnx in
/// the current folder, and the same in the folder the program was built in. Empty when there is none.
std::string saliency_model_file(const std::string& option);

}  // namespace uwv::pipeline
