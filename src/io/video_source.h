// SPDX-License-Identifier: Apache-2.0
// Frames of a video file.
#pragma once

#include <memory>

#include "uwv/io/frame_source.h"

namespace uwv {

std::unique_ptr<FrameSource> open_video(const std::string& path, const ClipOptions& options, Monitor& monitor);

}  // namespace uwv
