// SPDX-License-Identifier: Apache-2.0
// Opens a clip as it is: every frame, at its own size.
#pragma once

#include <memory>
#include <string>

#include "uwv/io/frame_source.h"

namespace uwv::pipeline {

inline std::unique_ptr<FrameSource> open_whole_clip(const std::string& path, Monitor& monitor) {
  ClipOptions options;
  options.max_frames = 0;
  options.resize.mode = ResizePolicy::Mode::none;
  return open_clip(path, options, monitor);
}

}  // namespace uwv::pipeline
