// SPDX-License-Identifier: Apache-2.0
#include "geometry/sfm/turning.h"

namespace uwv::sfm {

Reconstruction turn(const std::vector<Track>& tracks, int frames, const Intrinsics& lens, const GrowOptions& options) {
  constexpr std::size_t least = 8;  // matches that carry a rotation
  Reconstruction out;
  out.lens = lens;
  out.cam_from_world.resize(static_cast<std::size_t>(frames));
  out.points.resize(tracks.size());
  out.cam_from_world[0] = Rigid3{};
  int anchor = 0;
  for (int f = 1; f < frames; ++f) {
    PairMatches matches = matches_between(tracks, anchor, f);
    // Long steps drift less; a new anchor is taken before the common tracks run out.
    if (matches.size() < 60 && out.cam_from_world[static_cast<std::size_t>(f - 1)]) {
      anchor = f - 1;
      matches = matches_between(tracks, anchor, f);
    }
    if (matches.size() < least) continue;
    const Eigen::Matrix3d step = fit_rotation(matches, lens);
    out.cam_from_world[static_cast<std::size_t>(f)] =
        Rigid3{step * out.cam_from_world[static_cast<std::size_t>(anchor)]->rotation, Eigen::Vector3d::Zero()};
  }
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    const auto& pose = out.cam_from_world[static_cast<std::size_t>(tracks[t].first)];
    if (pose) out.points[t] = pose->rotation.transpose() * unproject(lens, tracks[t].pixels.front(), 1).normalized();
  }
  AdjustOptions adjustment;
  adjustment.refine_focal = options.refine_focal;
  adjustment.focal_prior = options.focal_prior;
  adjustment.fix_translation = true;
  for (const double gate : {8 * options.max_error_px, 2 * options.max_error_px}) {
    adjustment.gate_px = gate;
    adjust(out, tracks, adjustment);
  }
  return out;
}

}  // namespace uwv::sfm
