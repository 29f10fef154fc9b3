// SPDX-License-Identifier: Apache-2.0
#include "io/clip_range.h"

#include <algorithm>

namespace uwv::clip_range {

long last_needed(const ClipOptions& options) {
  return options.max_frames == 0 ? 0 : options.start + (options.max_frames - 1) * options.stride + 1;
}

long taken(long available, const ClipOptions& options, const std::string& path) {
  if (options.start >= available)
    fail(ErrorCode::value_invalid, "{}: start is {} but the clip has {} readable frames; choose a smaller start", path,
         options.start, available);
  const long reachable = (available - options.start - 1) / options.stride + 1;
  return options.max_frames == 0 ? reachable : std::min(reachable, options.max_frames);
}

void require_index(long index, long frames) {
  require(index >= 0 && index < frames, "frame {} was asked for; the clip has frames 0 to {}", index, frames - 1);
}

}  // namespace uwv::clip_range
