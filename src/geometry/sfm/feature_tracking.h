// SPDX-License-Identifier: Apache-2.0
// Corners followed through the clip by pyramidal Lucas-Kanade, each step checked by tracking it back.
#pragma once

#include <span>

#include "geometry/sfm/tracks.h"
#include "uwv/core/monitor.h"
#include "uwv/core/thread_pool.h"
#include "uwv/geometry/structure_from_motion.h"

namespace uwv::sfm {

/// Tracks of the whole clip and its cuts. The result does not depend on the number of threads.
TrackedClip track_features(std::span<const ImageRgb> frames, const SfmOptions& options, ThreadPool& pool,
                           Monitor& monitor);

}  // namespace uwv::sfm
