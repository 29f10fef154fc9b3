// SPDX-License-Identifier: Apache-2.0
// The first two cameras: five-point essential matrices (Nister 2004), and homographies where one plane fills the view.
#pragma once

#include "geometry/sfm/motion_kind.h"

namespace uwv::sfm {

struct TwoViewStart {
  FramePair frames;
  Rigid3 b_from_a;  ///< Translation of length 1.
  bool from_plane = false;
};

/// Pairs worth starting from, best first: many common tracks whose shift rotation does not explain.
std::vector<FramePair> rank_pairs(const std::vector<Track>& tracks, std::span<const FramePair> pairs,
                                  const Intrinsics& lens, Size size);
/// What the pair's relative pose can be: the essential matrix's, and the homography's where it explains as much. The
/// seed draws the samples both are chosen from.
std::vector<TwoViewStart> starts_of(const std::vector<Track>& tracks, const FramePair& pair, const Intrinsics& lens,
                                    double max_error_px, std::uint64_t seed);

}  // namespace uwv::sfm
