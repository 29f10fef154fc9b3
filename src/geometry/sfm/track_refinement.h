// SPDX-License-Identifier: Apache-2.0
// Tracks freed from drift. Following from frame to frame adds up an error at each step; here every place is found anew
// by its likeness to one patch of the track, that of its middle frame, under an affine warp and a change of brightness
// and contrast (inverse compositional alignment: Baker & Matthews 2004).
#pragma once

#include <span>
#include <vector>

#include "geometry/sfm/tracks.h"
#include "uwv/core/thread_pool.h"

namespace uwv::sfm {

/// As many tracks in the same order, none longer than it was: a track ends, on either side of its middle frame, where
/// the likeness is lost, and may be left with one place. `frames`: those of the shot, frame 0 of the tracks first;
/// `size`: of the picture the tracks were made in. The result does not depend on the number of threads.
std::vector<Track> refined_tracks(std::span<const ImageRgb> frames, Size size, const std::vector<Track>& tracks,
                                  ThreadPool& pool);

}  // namespace uwv::sfm
