// SPDX-License-Identifier: Apache-2.0
// The arithmetic of start, stride and max_frames, shared by every frame source.
#pragma once

#include <string>

#include "uwv/io/frame_source.h"

namespace uwv::clip_range {

/// Number of source frames the options reach into: start + (max_frames - 1) * stride + 1; 0 = all there are.
long last_needed(const ClipOptions& options);

/// How many frames are taken of `available` source frames. Throws Error(value_invalid) naming `path` when none is.
long taken(long available, const ClipOptions& options, const std::string& path);

/// Throws std::invalid_argument unless 0 <= index < frames.
void require_index(long index, long frames);

}  // namespace uwv::clip_range
