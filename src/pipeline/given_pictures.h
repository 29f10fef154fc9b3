// SPDX-License-Identifier: Apache-2.0
// Clips that go with the video frame by frame: masks, backgrounds.
#pragma once

#include <string>
#include <vector>

#include "uwv/core/image.h"
#include "uwv/core/monitor.h"
#include "uwv/pipeline/run_options.h"

namespace uwv::pipeline {

/// The pictures of `path` that belong to the used frames of the video, `count` of them, resized to `size`. `what` names
/// one of them in Error(size_mismatch), which is thrown when there are fewer.
std::vector<ImageRgb> read_given_pictures(const std::string& path, const std::string& what, const RunOptions& options,
                                          std::size_t count, Size size, Monitor& monitor);

}  // namespace uwv::pipeline
