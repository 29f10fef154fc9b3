// SPDX-License-Identifier: Apache-2.0
// Several beginnings are tried on few tracks, and the one that ends best is carried out on more: a wrong focal length,
// a pair dominated by a moving thing and the false twin of a plane's pose all show in the error they end with.
#pragma once

#include "geometry/sfm/incremental.h"
#include "uwv/core/monitor.h"

namespace uwv::sfm {

struct Exploration {
  std::vector<Intrinsics> lenses;  ///< Candidates, one when the lens is known.
  GrowOptions grow;
  Size size;
};

struct Outcome {
  bool found = false;
  Reconstruction reconstruction;
  bool from_plane = false;
  double misfit = 0;
  int tried = 0;
};

/// Tracks such that every listed frame keeps about `per_frame` of them, long ones first.
std::vector<Track> thinned(const std::vector<Track>& tracks, std::span<const int> frames, int per_frame);

Outcome reconstruct(const std::vector<Track>& tracks, int frames, std::span<const int> keyframes,
                    std::span<const FramePair> pairs, const Exploration& exploration, Monitor& monitor);

}  // namespace uwv::sfm
