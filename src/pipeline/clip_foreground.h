// SPDX-License-Identifier: Apache-2.0
// The foreground of a clip whose camera does not show it by moving: what the first frame is about, followed through the
// others, or the masks the user gives.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "uwv/core/thread_pool.h"
#include "uwv/geometry/layers.h"
#include "uwv/pipeline/run_options.h"

namespace uwv::pipeline {

struct ClipForeground {
  std::vector<ForegroundMask> masks;  ///< One a frame; none when nothing stands out.
  std::string note;                   ///< What was found and by whom.
};

/// Throws Error when the saliency model or the masks the options name cannot be used.
ClipForeground find_clip_foreground(const RunOptions& options, std::span<const ImageRgb> frames, ThreadPool& pool,
                                    Monitor& monitor);

/// The saliency network's file: the option's, else the first of UWV_MODELS/u2netp.onnx, .cache/models/u2netp.onnx in
/// the current folder, and the same in the folder the program was built in. Empty when there is none.
std::string saliency_model_file(const std::string& option);

}  // namespace uwv::pipeline
